// A clip as it comes: opened by another worker whenever more of it has come, while the one before draws.
import type { Camera, Vector } from "./camera.js";
import { Drawer } from "./drawer.js";
import type { ClipInfo, DrawnBy } from "./messages.js";
import type { ClipSource } from "./source.js";

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
  #openedAt = -Infinity;
  #complete = false;

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
      const { bytes, all, fault } = this.source;
      if (fault && bytes <= Math.max(this.#opened, 0)) throw fault;
      this.#openedAt = performance.now();
      this.#opened = bytes;
      this.#openedAll = all;
      const opened = await drawer.ask({ kind: "open", clip: this.source.blob(), name: this.name, by: this.by, all });
      this.#complete = opened.finished;
      if (opened.content) {
        this.#drawer = null;
        return { drawer, ...opened.content, complete: opened.finished };
      }
    }
    return null;
  }

  /** Another worker with all of the clip, once it is complete. */
  async another(): Promise<Drawer> {
    const drawer = this.#prepare();
    this.#drawer = null;
    await drawer.ask({ kind: "open", clip: this.source.blob(), name: this.name, by: this.by, all: true });
    return drawer;
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
    if (this.#opened > 0) await rest(this.#openedAt + patience - performance.now());
    await source.beyond(Math.max(headBytes, worthwhile * this.#opened));
  }
}

const headBytes = 4096; // in which a file says what it is
const rest = (milliseconds: number) => new Promise((resolve) => setTimeout(resolve, milliseconds));
