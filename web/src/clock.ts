// Which time is to be shown now. Seconds of the clip; `now` is any steady clock in seconds.
import type { Span } from "./messages.js";

const rounding = 1e-6; // seconds

export class PlaybackClock {
  loop = false;
  #rate = 1;
  #playing = false;
  #time = 0; // at #since
  #since = 0;

  #end: number;
  #come: readonly Span[] | null = null; // null: all has come

  constructor(
    readonly start: number,
    end: number,
    private now: () => number = steadySeconds,
  ) {
    this.#time = start;
    this.#end = end;
  }

  get end(): number {
    return this.#end;
  }
  /** Another end, as more has come. `come`: in which spans, if not all has: it waits at their ends, playing, and repeats nothing. */
  setEnd(end: number, come: readonly Span[] | null): void {
    this.#time = this.time;
    this.#since = this.now();
    this.#end = Math.max(end, this.start);
    this.#come = come;
    if (!come) this.#time = Math.min(this.#time, this.#end);
  }
  /** What has not come yet is waited for. */
  get starved(): boolean {
    return this.#come !== null && this.time >= this.#limit(this.#come);
  }
  /** Up to where it can go on from where it was set. */
  #limit(come: readonly Span[]): number {
    const span = come.find(({ from, to }) => from <= this.#time + rounding && this.#time <= to);
    return span?.to ?? this.#time;
  }
  /** Whose seconds go by while it plays: those of the sound that is heard, or of the system's steady clock. */
  setMaster(now: () => number): void {
    this.#time = this.time;
    this.now = now;
    this.#since = now();
  }

  get playing(): boolean {
    return this.#playing;
  }
  get rate(): number {
    return this.#rate;
  }
  /** 1/16 to 16. */
  set rate(rate: number) {
    this.seek(this.time);
    this.#rate = Math.min(Math.max(rate, 1 / 16), 16);
  }
  /** Stands at the end, if it does not loop; at what was sought, if that has not come yet. */
  get time(): number {
    if (!this.#playing) return this.#time;
    const time = this.#time + (this.now() - this.#since) * this.#rate;
    if (this.#come) return Math.min(time, this.#limit(this.#come));
    const span = this.end - this.start;
    if (time <= this.end || span <= 0) return Math.min(time, this.end);
    return this.loop ? this.start + ((time - this.start) % span) : this.end;
  }
  get ended(): boolean {
    return this.time >= this.end && !this.#come && !(this.loop && this.#playing);
  }

  play(): void {
    if (this.ended) this.#time = this.start;
    if (!this.#playing) this.#since = this.now();
    this.#playing = true;
  }
  pause(): void {
    this.#time = this.time;
    this.#playing = false;
  }
  seek(time: number): void {
    this.#time = Math.min(Math.max(time, this.start), this.#come ? Infinity : this.end);
    this.#since = this.now();
  }
}

export const steadySeconds = (): number => performance.now() / 1000;

/** Number of the last frame whose time has come. */
export function frameAt(times: Float64Array, time: number): number {
  let low = 0;
  let high = times.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= time + rounding) low = middle;
    else high = middle;
  }
  return low;
}
