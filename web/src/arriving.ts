// A clip as it comes: opened by another worker whenever more of it has come, while the one before draws.
import type { Camera, Vector } from "./camera.js";
import { playerCode } from "./code.js";
import { Drawer } from "./drawer.js";
import type { ClipInfo, DrawnBy } from "./messages.js";
import { firstBytes, type ClipSource } from "./source.js";

const patience = 250; // milliseconds between two that are opened
const worthwhile = 1.25; // times the bytes of the one before
const betweenLooks = 500; // milliseconds; at a file that grows

/** What has come of the clip. */
export interface OpenClip {
  drawer: Drawer;
  info: ClipInfo;
  capture: Camera;
  subject: Vector;
  complete: boolean; // nothing more will come
}

export class ArrivingClip {
  #drawer: Drawer | null = null; // that opens the next one; loads what it needs meanwhile
  #opened = -1; // bytes
  #openedAll = false;
  #coarse = false; // the last was a first look
  #openedAt = -Infinity;
  #complete = false;
  #tried = firstBytes; // then twice as many, until there is something to be seen
  #shows = false;

  constructor(
    private readonly source: ClipSource,
    private readonly name: string,
    private readonly by: DrawnBy,
    private readonly signal: AbortSignal,
  ) {
    this.#prepare();
  }

  /** The next that is more than the one before; null: there will be none. Rejects with a Fault: that is all there is. */
  async next(): Promise<OpenClip | null> {
    while (!this.#complete) {
      const drawer = this.#prepare();
      await this.#worthwhile();
      this.signal.throwIfAborted();
      const code = await playerCode();
      const { fault } = this.source;
      // What is small is ready soon.
      const whole = this.#shows || this.source.bytes <= this.#tried;
      const [bytes, all] = whole ? [this.source.bytes, this.source.all] : [this.#tried, false];
      this.#tried *= 2;
      if (fault && bytes <= Math.max(this.#opened, 0) && !this.#coarse) throw fault;
      this.#openedAt = performance.now();
      this.#opened = bytes;
      const firstLook = !this.#shows;
      const opened = await drawer.ask({ ...this.#call(code), clip: this.source.blob().slice(0, bytes), all, firstLook });
      this.#complete = opened.finished;
      this.#coarse = firstLook && opened.content !== null;
      this.#openedAll = all && !this.#coarse;
      if (opened.content) {
        this.#drawer = null;
        this.#shows = true;
        return { drawer, ...opened.content, complete: opened.finished };
      }
    }
    return null;
  }

  /** What is shown at that time is to come first. */
  seek(time: number): void {
    void this.source.seek(time);
  }

  /** Another worker with all of the clip, once it is complete. */
  async another(): Promise<Drawer> {
    const drawer = this.#prepare();
    this.#drawer = null;
    await drawer.ask({ ...this.#call(await playerCode()), clip: this.source.blob(), all: true, firstLook: false });
    return drawer;
  }

  #call(code: WebAssembly.Module) {
    return { kind: "open", code, name: this.name, by: this.by } as const;
  }

  #prepare(): Drawer {
    if (this.#drawer) return this.#drawer;
    const drawer = new Drawer();
    this.signal.addEventListener("abort", () => drawer.close());
    return (this.#drawer = drawer);
  }

  async #worthwhile(): Promise<void> {
    const { source } = this;
    while (this.#openedAll && source.bytes === this.#opened && !this.signal.aborted) {
      await rest(betweenLooks);
      await source.lookAgain();
    }
    if (this.#shows) await rest(this.#openedAt + patience - performance.now());
    await source.beyond(this.#shows ? worthwhile * this.#opened : Math.max(this.#opened, this.#tried - 1));
  }
}

const rest = (milliseconds: number) => new Promise((resolve) => setTimeout(resolve, milliseconds));
