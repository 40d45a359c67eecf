// An open clip on a canvas: asks its drawers for the picture that is wanted now, and shows what they bring.
import { poseOf, type Camera, type Vector, type View } from "./camera.js";
import { frameAt, PlaybackClock } from "./clock.js";
import { Drawer } from "./drawer.js";
import { FaultCode, type Fault } from "./faults.js";
import type { ClipInfo, DrawnBy, DrawRequest, Picture, ViewName } from "./messages.js";
import { Resolution, withPixels, type Size } from "./resolution.js";

const mostDrawers = 2;
const framesPerSecond = 30; // wanted while something moves
const restsAfter = 100; // milliseconds without a new camera
const lateAfter = 500; // milliseconds

export interface StageEvents {
  opening(): void; // all bytes are there
  shown(picture: Picture): void;
  waiting(late: boolean): void;
  ended(): void;
  failed(fault: Fault): void;
}

interface Asked {
  subject: string;
  full: boolean;
  number: number;
  at: number; // milliseconds
}

/** What has to be the same for two pictures to be the same but for their size. */
const subjectOf = (r: DrawRequest) => JSON.stringify([r.time, r.camera.pose, r.visible, r.view]);

export class Stage {
  readonly clock: PlaybackClock;
  readonly visible: boolean[];
  shows: ViewName = "color";
  #view: View | null = null;
  #drawers: Drawer[];
  #resolution: Resolution;
  #asked: Asked = { subject: "", full: false, number: 0, at: 0 };
  #shown = this.#asked;
  #cameraMoved = -Infinity;
  #lastMilliseconds = 0;
  #byGpu = false;
  #late = false;
  #lateSince = 0;
  #animation = 0;
  #ended = false;

  private constructor(
    readonly info: ClipInfo,
    readonly capture: Camera,
    readonly subject: Vector,
    first: Drawer,
    private readonly canvas: HTMLCanvasElement,
    private readonly events: StageEvents,
  ) {
    this.clock = new PlaybackClock(info.times[0]!, info.times[info.times.length - 1]!);
    this.visible = info.layers.map(() => true);
    this.#drawers = [first];
    this.#resolution = new Resolution((0.9 * 1000 * Stage.drawers) / framesPerSecond);
  }

  private static get drawers(): number {
    return Math.min(mostDrawers, navigator.hardwareConcurrency || 1);
  }

  /** Rejects with a Fault. */
  static async open(
    arriving: Promise<Blob>,
    name: string,
    by: DrawnBy,
    canvas: HTMLCanvasElement,
    signal: AbortSignal,
    events: StageEvents,
  ): Promise<Stage> {
    const first = new Drawer(); // loads what it needs meanwhile
    signal.addEventListener("abort", () => first.close());
    try {
      const clip = await arriving;
      signal.throwIfAborted();
      events.opening();
      const info = await first.ask({ kind: "open", clip, name, by });
      const capture = await first.ask({ kind: "captureCamera", time: info.times[0]! });
      const subject = await first.ask({ kind: "subject", time: info.times[0]! });
      const stage = new Stage(info, capture, subject, first, canvas, events);
      stage.#animate();
      void stage.#addDrawers(clip, name, by, signal);
      return stage;
    } catch (thrown) {
      first.close();
      throw thrown;
    }
  }

  get view(): View | null {
    return this.#view;
  }
  /** null: where the capture's camera was. */
  set view(view: View | null) {
    this.#view = view;
    this.#cameraMoved = performance.now();
  }

  /** Where the capture's camera was. */
  captureCamera(time: number): Promise<Camera> {
    return this.#drawers[0]!.ask({ kind: "captureCamera", time });
  }

  /** What is to be shown now. */
  get wanted(): Pick<DrawRequest, "time" | "visible" | "view"> {
    const time = this.info.times[frameAt(this.info.times, this.clock.time)]!;
    return { time, visible: [...this.visible], view: this.shows };
  }

  /** The full picture of what is wanted now is shown. */
  get settled(): boolean {
    const rests = !this.#moves(performance.now());
    return rests && this.#shown.full && this.#shown.subject === this.#restingSubject(this.#fullSize());
  }

  /** A picture for somebody else's canvas. */
  draw(request: DrawRequest): Promise<Picture> {
    return this.#idle().ask({ kind: "draw", request });
  }

  close(): void {
    cancelAnimationFrame(this.#animation);
    for (const drawer of this.#drawers) drawer.close();
  }

  /** Each has the clip for itself: threads that share memory need pages that are isolated, which few are. */
  async #addDrawers(clip: Blob, name: string, by: DrawnBy, signal: AbortSignal): Promise<void> {
    while (this.#drawers.length < Stage.drawers && !signal.aborted) {
      while (this.#shown.number === 0 && !signal.aborted) await new Promise((resolve) => setTimeout(resolve, 50));
      if (this.#byGpu) return; // there is one, and it is fast enough
      const drawer = new Drawer();
      signal.addEventListener("abort", () => drawer.close());
      try {
        await drawer.ask({ kind: "open", clip, name, by });
      } catch {
        drawer.close(); // one less: slower, and no fault
        return;
      }
      if (!signal.aborted) this.#drawers.push(drawer);
    }
  }

  #idle(): Drawer {
    return this.#drawers.find((drawer) => !drawer.busy) ?? this.#drawers[0]!;
  }

  #animate(): void {
    this.#animation = requestAnimationFrame(() => this.#animate());
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
    const size = moves ? this.#resolution.moving(full) : full;
    const request = this.#request(size, moves);
    const subject = moves ? subjectOf(request) : this.#restingSubject(full);
    if (subject === this.#asked.subject) return;
    // Several drawers take turns: their pictures should come evenly.
    const pause = moves && this.#drawers.length > 1 ? (0.8 * this.#lastMilliseconds) / this.#drawers.length : 0;
    if (idle.length === 0 || now - this.#asked.at < pause) return;
    this.#asked = { subject, full: !moves, number: this.#asked.number + 1, at: now };
    const asked = this.#asked;
    idle[0]!.ask({ kind: "draw", request }).then(
      (picture) => this.#show(picture, asked, moves),
      (fault: Fault) => {
        if (fault.code !== FaultCode.aborted) this.events.failed(fault);
      },
    );
  }

  #moves(now: number): boolean {
    return this.clock.playing || now - this.#cameraMoved < restsAfter;
  }

  #restingSubject(full: Size): string {
    return subjectOf(this.#request(full, false)) + JSON.stringify(full);
  }

  #request({ width, height }: Size, preview: boolean): DrawRequest {
    const pose = this.#view ? poseOf(this.#view) : null;
    return { ...this.wanted, camera: { pose, width, height }, preview, withDepth: false };
  }

  #show(picture: Picture, asked: Asked, moves: boolean): void {
    if (moves) {
      this.#resolution.drawn(picture.camera, picture.milliseconds);
      this.#lastMilliseconds = picture.milliseconds;
    }
    if (asked.number < this.#shown.number) return; // a later one was faster
    this.#shown = asked;
    this.#byGpu = picture.by === "webgl";
    this.#lateSince = performance.now();
    const { width, height } = picture.camera;
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    this.canvas.getContext("2d")!.putImageData(new ImageData(picture.color, width, height), 0, 0);
    this.events.shown(picture);
  }

  #tellLate(now: number): void {
    if (!this.clock.playing || this.#shown.number >= this.#asked.number) this.#lateSince = now;
    const late = now - this.#lateSince > lateAfter;
    if (late !== this.#late) this.events.waiting(late);
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
