// <kinora-player src="clip.mkv">: a custom element with <video>'s attributes, events and methods, and `camera`.
import { viewOf, type Camera, type View } from "./camera.js";
import { playerCode } from "./code.js";
import { Controls } from "./controls.js";
import { asFault, FaultCode, type Fault } from "./faults.js";
import { listenToPointers, viewAfterKey } from "./gestures.js";
import { formatPlace, type Place } from "./link.js";
import { MediaAttributes } from "./media.js";
import { makeMenu } from "./menu.js";
import type { DrawnBy, Layer, ViewName } from "./messages.js";
import { ArrivingClip } from "./arriving.js";
import { ClipSource } from "./source.js";
import { Stage } from "./stage.js";
import { stateOfArrival, Surface } from "./surface.js";

const quarterSecond = 250; // between two timeupdate events, at least

export class KinoraPlayerElement extends MediaAttributes {
  static readonly observedAttributes = ["src", "poster", "loop", "controls", "muted"];

  #surface: Surface;
  #controls: Controls;
  #opening = new AbortController();
  #stage: Stage | null = null;
  #pictureCamera: Camera | null = null; // of the last picture that was shown
  #fault: Fault | null = null;
  #file: File | null = null;
  #place: Place = {}; // where the next clip starts
  #rate = 1;
  #volume = 1;
  #loading = false;
  #seeking = false;
  #toldAt = 0;
  #showsPlaying = false;

  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" });
    this.#surface = new Surface(root);
    this.#controls = new Controls({
      togglePlay: () => this.#togglePlay(),
      seek: (time) => (this.currentTime = time),
      fillMenu: (menu) => this.#fillMenu(menu),
      toggleMuted: () => (this.muted = !this.muted),
      toggleFullScreen: () => this.#toggleFullScreen(),
    });
    root.append(this.#controls.menu, this.#controls.bar);
    listenToPointers(this.#surface.stage, {
      view: () => this.#viewNow(),
      turn: (view) => (this.camera = view),
      heightAtOne: () => (this.#pictureCamera ? this.#pictureCamera.height / this.#pictureCamera.fy : 1),
    });
    this.#surface.stage.addEventListener("dblclick", () => this.#toggleFullScreen());
    this.#surface.stage.addEventListener("keydown", (event) => this.#key(event));
    this.#surface.file.addEventListener("change", () => this.openFile(this.#surface.file.files?.[0] ?? null));
    this.#acceptDrops();
  }

  connectedCallback(): void {
    this.#controls.bar.hidden = !this.controls;
    this.#surface.setPoster(this.poster);
    this.load();
  }

  disconnectedCallback(): void {
    this.#close();
  }

  attributeChangedCallback(name: string, before: string | null, now: string | null): void {
    if (name === "poster") this.#surface.setPoster(this.#pictureCamera ? "" : this.poster);
    if (name === "controls") this.#controls.bar.hidden = !this.controls;
    if (name === "loop" && this.#stage) this.#stage.clock.loop = this.loop;
    if (name === "muted" && before !== now) {
      this.#showSound();
      this.#tell("volumechange");
    }
    if (name === "src" && before !== now && this.isConnected) {
      this.#file = null;
      this.load();
    }
  }

  // ---- what it shows and when, as <video>

  /** Starts anew with `src`, or with the file that was opened. */
  load(): void {
    this.#close();
    this.#surface.setEmpty(!this.#file && !this.src);
    const { signal } = this.#opening;
    if (this.#file) void this.#open(ClipSource.ofFile(this.#file, signal), this.#file.name);
    else if (this.src) void this.#open(this.#fetched(), this.src);
  }

  /** Shows a file of this machine's. */
  openFile(file: File | null): void {
    if (!file) return;
    this.#file = file;
    this.#place = {};
    this.load();
  }

  /** Starts as soon as there is a clip. */
  async play(): Promise<void> {
    if (!this.#stage) {
      if (!this.#loading) throw new DOMException("there is no clip to play", "NotSupportedError");
      await new Promise<void>((resolve, reject) => {
        this.addEventListener("loadedmetadata", () => resolve(), { once: true });
        this.addEventListener("error", () => reject(new DOMException(this.#fault?.message, "NotSupportedError")), { once: true });
      });
    }
    this.#stage?.clock.play();
    this.#showPlaying();
  }
  pause(): void {
    this.#stage?.clock.pause();
    this.#showPlaying();
  }
  get paused(): boolean {
    return !this.#stage?.clock.playing;
  }
  get ended(): boolean {
    return this.#stage?.clock.ended ?? false;
  }
  get seeking(): boolean {
    return this.#seeking;
  }
  get currentTime(): number {
    return this.#stage ? this.#stage.clock.time : (this.#place.time ?? 0);
  }
  set currentTime(time: number) {
    if (!Number.isFinite(time)) throw new TypeError("currentTime is no number");
    if (!this.#stage) {
      this.#place.time = time;
      return;
    }
    this.#seeking = true;
    this.#stage.seek(time);
    this.#tell("seeking");
  }
  /** Of the last frame that has come, seconds; NaN: not known yet. */
  get duration(): number {
    return this.#stage ? this.#stage.clock.end : NaN;
  }
  get playbackRate(): number {
    return this.#rate;
  }
  /** 1/16 to 16. */
  set playbackRate(rate: number) {
    if (!(rate >= 1 / 16 && rate <= 16)) throw new DOMException("playbackRate goes from 1/16 to 16", "NotSupportedError");
    this.#rate = rate;
    if (this.#stage) this.#stage.clock.rate = rate;
    this.#tell("ratechange");
  }
  get volume(): number {
    return this.#volume;
  }
  /** 0 to 1. */
  set volume(volume: number) {
    if (!(volume >= 0 && volume <= 1)) throw new DOMException("volume goes from 0 to 1", "IndexSizeError");
    this.#volume = volume;
    if (this.#stage) this.#stage.sound.volume = volume;
    this.#tell("volumechange");
  }
  /** As of HTMLMediaElement: 0 nothing, 1 metadata, 3 a part, 4 all has come. */
  get readyState(): number {
    return this.#pictureCamera ? (this.#stage!.complete ? 4 : 3) : this.#stage ? 1 : 0;
  }
  /** What is wrong: a code of MediaError's, and a sentence. */
  get error(): { code: number; message: string } | null {
    return this.#fault && { code: this.#fault.code, message: this.#fault.message };
  }

  // ---- from where, and what of it

  /** null: where the capture's camera was. */
  get camera(): View | null {
    return this.#stage ? this.#stage.view : (this.#place.view ?? null);
  }
  set camera(view: View | null) {
    if (this.#stage) this.#stage.view = view;
    else if (view) this.#place.view = view;
    else delete this.#place.view;
    this.#tell("camerachange");
  }
  get layers(): readonly Layer[] {
    return this.#stage?.info.layers ?? [];
  }
  setLayerVisible(layer: number, visible: boolean): void {
    this.#stage?.setVisible(layer, visible);
  }
  get shows(): ViewName {
    return this.#stage?.shows ?? "color";
  }
  set shows(view: ViewName) {
    if (this.#stage) this.#stage.shows = view;
  }
  /** Time and camera as the end of an address: #t=2.4&cam=… */
  get place(): string {
    return formatPlace(this.currentTime, this.camera);
  }
  /** Who draws, from the next clip on: "auto", "cpu" or "webgl". */
  get drawnBy(): DrawnBy {
    const stated = this.getAttribute("drawn-by");
    return stated === "cpu" || stated === "webgl" ? stated : "auto";
  }
  set drawnBy(by: DrawnBy) {
    this.setAttribute("drawn-by", by);
  }
  /** The open clip: for those who draw it themselves. */
  get stage(): Stage | null {
    return this.#stage;
  }
  /** The camera and size of the picture that is shown. */
  get pictureCamera(): Camera | null {
    return this.#pictureCamera;
  }

  // ---- opening

  #fetched(): ClipSource {
    const source = ClipSource.fetched(new URL(this.src, document.baseURI).href, this.#opening.signal, playerCode(), () => {
      if (!this.#stage) this.#surface.setState(stateOfArrival(source.bytes, source.size));
      this.#tell("progress");
    });
    return source;
  }

  async #open(source: ClipSource, name: string): Promise<void> {
    const { signal } = this.#opening;
    this.#loading = true;
    this.#surface.setState("Loading");
    this.#tell("loadstart");
    try {
      const events = {
        changed: () => this.#changed(),
        shown: (camera: Camera) => this.#shown(camera),
        waiting: (late: boolean, starved: boolean) => this.#waiting(late, starved),
        lacks: (fault: Fault) => this.#say(fault),
        ended: () => this.#ended(),
        failed: (fault: Fault) => this.#fail(fault),
      };
      const clip = new ArrivingClip(source, name, this.drawnBy, signal);
      const stage = await Stage.open(clip, this.#surface.canvas, signal, events);
      if (signal.aborted) return stage.close();
      this.#start(stage);
    } catch (thrown) {
      if (!signal.aborted) this.#fail(asFault(thrown));
    }
  }

  #start(stage: Stage): void {
    this.#stage = stage;
    this.#loading = false;
    stage.clock.loop = this.loop;
    stage.clock.rate = this.#rate;
    stage.sound.volume = this.#volume;
    this.#showSound();
    if (this.#place.time !== undefined) stage.seek(this.#place.time);
    if (this.#place.view) stage.view = this.#place.view;
    this.#place = {};
    this.#surface.setState("Drawing");
    this.#showTime();
    this.#tell("durationchange");
    this.#tell("loadedmetadata");
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (this.autoplay && !still) void this.play();
  }

  #close(): void {
    if (this.#loading) this.#tell("abort");
    this.#opening.abort();
    this.#opening = new AbortController();
    this.#stage?.close();
    const had = this.#stage !== null;
    this.#stage = null;
    this.#pictureCamera = null;
    this.#fault = null;
    this.#loading = false;
    this.#seeking = false;
    this.#surface.clear();
    this.#surface.setPoster(this.poster);
    this.#controls.openMenu(false);
    this.#showPlaying();
    if (had) this.#tell("emptied");
  }

  #fail(fault: Fault): void {
    this.#close();
    this.#say(fault);
  }

  /** What is shown stays. */
  #say(fault: Fault): void {
    this.#fault = fault;
    this.#surface.setFault(fault.message, this.#pictureCamera !== null);
    this.dispatchEvent(new ErrorEvent("error", { message: fault.message, error: fault }));
  }

  // ---- while it is open

  /** More of the clip has come. */
  #changed(): void {
    this.#showTime();
    this.#showSound();
    this.#controls.refillMenu();
    this.#tell("durationchange");
    if (this.#stage!.complete && this.#pictureCamera) this.#tell("canplaythrough");
  }

  #shown(camera: Camera): void {
    const first = this.#pictureCamera === null;
    this.#pictureCamera = camera;
    if (first) {
      this.#surface.setPoster("");
      this.#surface.setState(null);
      if (this.#fault) this.#surface.setFault(this.#fault.message, true);
      this.#tell("loadeddata");
      this.#tell("canplay");
      if (this.#stage!.complete) this.#tell("canplaythrough");
    }
    this.#showTime();
    if (this.#seeking && !this.#stage!.clock.starved) {
      this.#seeking = false;
      this.#toldAt = 0;
      this.#tell("seeked");
    }
    const now = performance.now();
    if (now - this.#toldAt >= quarterSecond) {
      this.#toldAt = now;
      this.#tell("timeupdate");
    }
  }

  #waiting(late: boolean, starved: boolean): void {
    this.#surface.setState(late ? (starved ? "Loading" : "Drawing") : null);
    this.#tell(late ? "waiting" : "playing");
  }

  #ended(): void {
    this.#stage?.clock.pause();
    this.#showPlaying();
    this.#tell("timeupdate");
    this.#tell("ended");
  }

  #showTime(): void {
    const stage = this.#stage;
    if (stage) this.#controls.setTime(stage.clock.time, stage.clock.start, stage.end);
  }

  #showSound(): void {
    const sound = this.#stage?.sound;
    if (sound) sound.muted = this.muted;
    this.#controls.setSound(sound?.there ?? false, this.muted);
  }

  #showPlaying(): void {
    const playing = !this.paused;
    if (playing === this.#showsPlaying) return;
    this.#showsPlaying = playing;
    this.classList.toggle("playing", playing);
    this.#controls.setPlaying(playing);
    if (this.#stage) this.#tell(playing ? "play" : "pause");
    if (playing) this.#tell("playing");
  }

  #tell(event: string): void {
    this.dispatchEvent(new Event(event));
  }

  // ---- what people do

  #togglePlay(): void {
    if (!this.#stage) return;
    if (this.paused) void this.play();
    else this.pause();
  }

  #viewNow(): View | null {
    if (!this.#stage || !this.#pictureCamera) return null;
    return this.#stage.view ?? viewOf(this.#pictureCamera.cameraToWorld, this.#stage.subject);
  }

  #key(event: KeyboardEvent): void {
    const stage = this.#stage;
    if (!stage || event.ctrlKey || event.altKey || event.metaKey) return;
    const view = this.#viewNow();
    const turned = view && viewAfterKey(event, view);
    const actions: Record<string, () => void> = {
      " ": () => this.#togglePlay(),
      k: () => this.#togglePlay(),
      ArrowLeft: () => (this.currentTime -= 1),
      ArrowRight: () => (this.currentTime += 1),
      ",": () => this.#step(-1),
      ".": () => this.#step(1),
      "0": () => (this.camera = null),
      Home: () => (this.camera = null),
      m: () => (this.muted = !this.muted),
      l: () => (this.loop = !this.loop),
      f: () => this.#toggleFullScreen(),
    };
    if (turned) this.camera = turned;
    else if (actions[event.key]) actions[event.key]!();
    else return;
    event.preventDefault();
  }

  #step(frames: number): void {
    this.pause();
    this.currentTime = this.currentTime + (frames + 0.01) / (this.#stage?.info.framesPerSecond ?? 30);
  }

  #fillMenu(menu: HTMLElement): void {
    const stage = this.#stage;
    if (!stage) return menu.replaceChildren();
    const state = { layers: stage.visible, view: stage.shows, rate: this.#rate, loop: this.loop };
    const items = makeMenu(stage.info, state, {
      setLayer: (layer, visible) => this.setLayerVisible(layer, visible),
      setView: (view) => (this.shows = view),
      setRate: (rate) => (this.playbackRate = rate),
      setLoop: (loop) => (this.loop = loop),
      resetCamera: () => (this.camera = null),
      copyLink: () => void this.#copyLink(),
      chooseFile: () => this.#surface.file.click(),
    });
    menu.replaceChildren(...items);
  }

  async #copyLink(): Promise<void> {
    const address = location.href.replace(/#.*/, "") + this.place;
    history.replaceState(history.state, "", this.place);
    await navigator.clipboard?.writeText(address).catch(() => undefined); // the page's address has it in any case
  }

  #toggleFullScreen(): void {
    const change = document.fullscreenElement === this ? document.exitFullscreen() : this.requestFullscreen?.();
    change?.catch(() => undefined); // not allowed here
  }

  #acceptDrops(): void {
    const mark = (on: boolean) => this.classList.toggle("dropping", on);
    this.addEventListener("dragover", (event) => {
      event.preventDefault();
      mark(true);
    });
    this.addEventListener("dragleave", () => mark(false));
    this.addEventListener("drop", (event) => {
      event.preventDefault();
      mark(false);
      this.openFile(event.dataTransfer?.files[0] ?? null);
    });
  }
}

/** For code that listens to `error`. */
export { FaultCode };
