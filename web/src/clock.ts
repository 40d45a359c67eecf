// Which time is to be shown now. Seconds of the clip; `now` is any steady clock in seconds.

export class PlaybackClock {
  loop = false;
  #rate = 1;
  #playing = false;
  #time = 0; // at #since
  #since = 0;

  constructor(
    readonly start: number,
    readonly end: number,
    private readonly now: () => number = () => performance.now() / 1000,
  ) {
    this.#time = start;
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
  /** Stands at the end, if it does not loop. */
  get time(): number {
    if (!this.#playing) return this.#time;
    const time = this.#time + (this.now() - this.#since) * this.#rate;
    const span = this.end - this.start;
    if (time <= this.end || span <= 0) return Math.min(time, this.end);
    return this.loop ? this.start + ((time - this.start) % span) : this.end;
  }
  get ended(): boolean {
    return this.time >= this.end && !(this.loop && this.#playing);
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
    this.#time = Math.min(Math.max(time, this.start), this.end);
    this.#since = this.now();
  }
}

/** Number of the last frame whose time has come. */
export function frameAt(times: Float64Array, time: number): number {
  let low = 0;
  let high = times.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= time + 1e-6) low = middle;
    else high = middle;
  }
  return low;
}
