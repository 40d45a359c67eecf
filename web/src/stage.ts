// An open clip on a canvas: asks its drawers for the picture that is wanted now, and shows what they bring.
import type { ArrivingClip, OpenClip } from "./arriving.js";
import { fitted, poseOf, type Camera, type Vector, type View } from "./camera.js";
import { frameAt, PlaybackClock } from "./clock.js";
import type { Drawer } from "./drawer.js";
import { asFault, Fault, FaultCode } from "./faults.js";
import type { ClipInfo, DrawRequest, Picture, ViewName } from "./messages.js";
import { SoundPlayback, soundUpTo } from "./sound.js";
import { Resolution, withPixels, type Size } from "./resolution.js";

const mostDrawers = 2;
const framesPerSecond = 30; // wanted while something moves
const restsAfter = 100; // milliseconds without a new camera
const lateAfter = 500; // milliseconds
const fewestRows = 64; // of a picture that several drawers share
const firstAlone = 500; // milliseconds for which nothing else is done while the first picture is drawn

export interface StageEvents {
  changed(): void; // more of the clip has come
  shown(camera: Camera): void; // a picture by it
  waiting(late: boolean, starved: boolean): void;
  lacks(fault: Fault): void; // something of the clip will not come
  ended(): void;
  failed(fault: Fault): void;
}

interface Asked {
  subject: string;
  full: boolean;
  number: number;
  at: number; // milliseconds
  repeats: number; // pictures before it by the same camera and of the same size
}

/** What has to be the same for two pictures to be the same but for their size. */
const subjectOf = (r: DrawRequest) => JSON.stringify([r.time, r.camera.pose, r.visible, r.view]);

export class Stage {
  readonly clock: PlaybackClock;
  readonly sound: SoundPlayback;
  shows: ViewName = "color";
  #open: OpenClip;
  #version = 0; // of what has come
  #hidden = new Set<string>(); // names of layers
  #view: View | null = null;
  #drawers: Drawer[];
  #spare: ArrayBuffer[] = []; // of pictures that were shown: others are drawn into them
  // While the camera rests, a drawer's pictures of one size cost less from the third on.
  #whileCameraMoves: Resolution;
  #whileCameraRests: Resolution;
  #asked: Asked = { subject: "", full: false, number: 0, at: 0, repeats: 0 };
  #askedCamera = "";
  #shown = this.#asked;
  #cameraMoved = -Infinity;
  #lastMilliseconds = 0;
  #byGpu = false;
  #late = false;
  #lateSince = 0;
  #animation = 0;
  #ended = false;

  private constructor(
    private readonly clip: ArrivingClip,
    first: OpenClip,
    private readonly canvas: HTMLCanvasElement,
    private readonly events: StageEvents,
  ) {
    this.#open = first;
    const { times } = first.info;
    this.clock = new PlaybackClock(times[0]!, times[times.length - 1]!);
    this.clock.setEnd(this.clock.end, first.complete ? null : first.info.come);
    this.sound = new SoundPlayback((why) => console.warn(`Kinora: ${why}`));
    void this.#takeSound();
    this.#drawers = [first.drawer];
    const budget = (0.9 * 1000 * Stage.drawers) / framesPerSecond;
    this.#whileCameraMoves = new Resolution(budget);
    this.#whileCameraRests = new Resolution(budget);
  }

  private static get drawers(): number {
    return Math.min(mostDrawers, navigator.hardwareConcurrency || 1);
  }

  /** Rejects with a Fault. */
  static async open(
    clip: ArrivingClip,
    canvas: HTMLCanvasElement,
    signal: AbortSignal,
    events: StageEvents,
  ): Promise<Stage> {
    const first = await clip.next();
    signal.throwIfAborted();
    const stage = new Stage(clip, first!, canvas, events); // the first is there, or it rejects
    stage.#animate();
    void stage.#follow(signal);
    return stage;
  }

  get info(): ClipInfo {
    return this.#open.info;
  }
  get capture(): Camera {
    return this.#open.capture;
  }
  get subject(): Vector {
    return this.#open.subject;
  }
  /** All of the clip has come. */
  get complete(): boolean {
    return this.#open.complete;
  }
  get visible(): boolean[] {
    return this.info.layers.map(({ name }) => !this.#hidden.has(name));
  }
  setVisible(layer: number, visible: boolean): void {
    const name = this.info.layers[layer]?.name;
    if (name === undefined) return;
    if (visible) this.#hidden.delete(name);
    else this.#hidden.add(name);
  }

  get view(): View | null {
    return this.#view;
  }
  /** null: where the capture's camera was. */
  set view(view: View | null) {
    this.#view = view;
    this.#cameraMoved = performance.now();
  }

  /** What has not come yet is fetched before what lies between, where that can be. */
  seek(time: number): void {
    this.clock.seek(time);
    if (this.clock.starved) this.clip.seek(time);
  }
  /** Of the last frame, whether it has come or not. */
  get end(): number {
    return this.complete ? this.clock.end : Math.max(this.info.end, this.clock.end);
  }

  /** Where the capture's camera was. */
  captureCamera(time: number): Promise<Camera> {
    return this.#drawers[0]!.ask({ kind: "captureCamera", time });
  }

  /** What is to be shown now. */
  get wanted(): Pick<DrawRequest, "time" | "visible" | "view"> {
    const time = this.info.times[frameAt(this.info.times, this.#timeThatCame(this.clock.time))]!;
    return { time, visible: this.visible, view: this.shows };
  }

  /** The last of what has come up to that time. */
  #timeThatCame(time: number): number {
    if (this.complete) return time;
    const span = this.info.come.filter(({ from }) => from <= time).at(-1);
    return span ? Math.min(time, span.to) : time;
  }

  /** The full picture of what is wanted now is shown. */
  get settled(): boolean {
    const rests = !this.#moves(performance.now());
    return rests && this.complete && this.#shown.full && this.#shown.subject === this.#restingSubject(this.#fullSize());
  }

  /** A picture for somebody else's canvas. */
  draw(request: DrawRequest): Promise<Picture> {
    return this.#idle().ask({ kind: "draw", request });
  }

  close(): void {
    cancelAnimationFrame(this.#animation);
    this.sound.close();
    for (const drawer of this.#drawers) drawer.close();
  }

  /** Takes more of the clip as it comes. */
  async #follow(signal: AbortSignal): Promise<void> {
    const { clip } = this;
    try {
      const opened = performance.now();
      while (this.#shown.number === 0 && performance.now() - opened < firstAlone) await new Promise((resolve) => setTimeout(resolve, 10));
      for (let more = await clip.next(); more; more = await clip.next()) {
        if (signal.aborted) return;
        this.#take(more);
      }
      if (this.info.missing) this.events.lacks(new Fault(FaultCode.decode, this.info.missing));
      await this.#addDrawers(signal);
    } catch (thrown) {
      if (signal.aborted) return;
      this.#take({ ...this.#open, complete: true }); // there is no more to be waited for
      this.events.lacks(asFault(thrown));
    }
  }

  async #takeSound(): Promise<void> {
    const sound = await this.#open.drawer.ask({ kind: "sound" }).catch(() => null); // it was closed
    if (!sound) return;
    const come = this.complete ? Infinity : (this.info.come[0]?.to ?? -Infinity); // what follows a gap is not heard yet
    this.sound.setSound(soundUpTo(sound, come));
    this.events.changed();
  }

  #take(more: OpenClip): void {
    const before = this.#drawers;
    this.#open = more;
    const { times } = more.info;
    this.clock.setEnd(times[times.length - 1]!, more.complete ? null : more.info.come);
    if (!before.includes(more.drawer)) {
      this.#version += 1;
      this.#drawers = [more.drawer];
      for (const drawer of before) drawer.retire();
      void this.#takeSound();
    }
    this.events.changed();
  }

  /** Each has the clip for itself: threads that share memory need pages that are isolated, which few are. */
  async #addDrawers(signal: AbortSignal): Promise<void> {
    while (this.#shown.number === 0 && !signal.aborted) await new Promise((resolve) => setTimeout(resolve, 50));
    while (this.#drawers.length < Stage.drawers && !this.#byGpu && !signal.aborted) {
      const drawer = await this.clip.another().catch(() => null); // one less: slower, and no fault
      if (!drawer || signal.aborted) return drawer?.close();
      this.#drawers.push(drawer);
    }
  }

  #idle(): Drawer {
    return this.#drawers.find((drawer) => !drawer.busy) ?? this.#drawers[0]!;
  }

  #animate(): void {
    this.#animation = requestAnimationFrame(() => this.#animate());
    this.sound.follow(this.clock);
    const now = performance.now();
    const full = this.#fullSize();
    if (full.width < 1 || full.height < 1) return; // not to be seen
    this.#ask(full, this.#moves(now), now);
    this.#tellLate(now);
    if (this.clock.playing && this.clock.ended) {
      if (!this.#ended) this.events.ended();
      this.#ended = true;
    } else {
      this.#ended = false;
    }
  }

  #ask(full: Size, moves: boolean, now: number): void {
    const idle = this.#drawers.filter((drawer) => !drawer.busy);
    const cameraMoves = this.#cameraMoves(now);
    const resolution = cameraMoves ? this.#whileCameraMoves : this.#whileCameraRests;
    const size = moves ? resolution.moving(full) : full;
    const request = this.#request(size, moves);
    const subject = moves ? subjectOf(request) + this.#version : this.#restingSubject(full);
    if (subject === this.#asked.subject) return;
    // Several drawers take turns: their pictures should come evenly.
    const pause = moves && this.#drawers.length > 1 ? (0.8 * this.#lastMilliseconds) / this.#drawers.length : 0;
    const inOne = moves || this.#byGpu || request.view === "depth" || size.height < fewestRows; // depths: relative to all
    const parts = inOne ? 1 : this.#drawers.length;
    if (idle.length < parts || now - this.#asked.at < pause) return;
    const camera = JSON.stringify([request.camera, request.visible, request.view, this.#version]);
    const repeats = camera === this.#askedCamera ? this.#asked.repeats + 1 : 0;
    this.#askedCamera = camera;
    this.#asked = { subject, full: !moves, number: this.#asked.number + 1, at: now, repeats };
    const asked = this.#asked;
    this.#drawn(request, idle.slice(0, parts)).then(
      (picture) => {
        const settled = cameraMoves || asked.repeats >= 2 * this.#drawers.length;
        if (moves && settled) resolution.drawn(picture.camera, picture.milliseconds);
        this.#show(picture, asked, moves);
      },
      (fault: Fault) => {
        if (fault.code !== FaultCode.aborted) this.events.failed(fault);
      },
    );
  }

  /** By these drawers at once: each draws a strip of the picture. */
  async #drawn(request: DrawRequest, drawers: Drawer[]): Promise<Picture> {
    if (drawers.length === 1) {
      const into = this.#spare.pop();
      return drawers[0]!.ask({ kind: "draw", request, into }, into ? [into] : []);
    }
    const { pose, width, height } = request.camera;
    const camera = fitted(this.capture, width, height, pose ?? this.capture.cameraToWorld);
    const rowsOfEach = Math.ceil(height / drawers.length);
    const strips = await Promise.all(
      drawers.map((drawer, i) => {
        const top = i * rowsOfEach;
        const rows = Math.min(rowsOfEach, height - top);
        const { fx, fy, cx, cy } = camera;
        const strip = { pose, width, height: rows, intrinsics: { fx, fy, cx, cy: cy - top } };
        return drawer.ask({ kind: "draw", request: { ...request, camera: strip } });
      }),
    );
    const color = new Uint8ClampedArray(4 * width * height);
    strips.forEach((strip, i) => color.set(strip.color, 4 * width * rowsOfEach * i));
    const milliseconds = Math.max(...strips.map((strip) => strip.milliseconds));
    return { ...strips[0]!, camera: { ...strips[0]!.camera, height, cy: camera.cy }, color, milliseconds };
  }

  /** The first picture is one that is soon there. */
  #moves(now: number): boolean {
    return this.#shown.number === 0 || this.clock.playing || this.#cameraMoves(now);
  }

  #cameraMoves(now: number): boolean {
    return now - this.#cameraMoved < restsAfter;
  }

  #restingSubject(full: Size): string {
    return subjectOf(this.#request(full, false)) + JSON.stringify([full, this.#version]);
  }

  #request({ width, height }: Size, preview: boolean): DrawRequest {
    const pose = this.#view ? poseOf(this.#view) : null;
    return { ...this.wanted, camera: { pose, width, height }, preview, withDepth: false };
  }

  #show(picture: Picture, asked: Asked, moves: boolean): void {
    if (moves) this.#lastMilliseconds = picture.milliseconds;
    if (asked.number >= this.#shown.number) this.#put(picture, asked); // else a later one was faster
    if (this.#spare.length < mostDrawers) this.#spare.push(picture.color.buffer);
  }

  #put(picture: Picture, asked: Asked): void {
    this.#shown = asked;
    this.#byGpu = picture.by === "webgl";
    this.#lateSince = performance.now();
    const { width, height } = picture.camera;
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    this.canvas.getContext("2d")!.putImageData(new ImageData(picture.color, width, height), 0, 0);
    this.events.shown(picture.camera);
  }

  #tellLate(now: number): void {
    const { starved, playing } = this.clock;
    const drawn = this.#shown.number >= this.#asked.number;
    if (!starved && (!playing || drawn)) this.#lateSince = now;
    const late = now - this.#lateSince > lateAfter;
    if (late !== this.#late) this.events.waiting(late, starved);
    this.#late = late;
  }

  /** As many pixels as the screen shows, and no more than the capture had: more would show nothing more. */
  #fullSize(): Size {
    const box = this.canvas.parentElement!;
    const screen = { width: box.clientWidth * devicePixelRatio, height: box.clientHeight * devicePixelRatio };
    if (screen.width < 1 || screen.height < 1) return { width: 0, height: 0 };
    return withPixels(screen, this.capture.width * this.capture.height);
  }
}
