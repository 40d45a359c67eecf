// The bytes of a clip as they come: over a network, from the first on or from what is sought; or out of a file of this
// machine.
import { Cues, frontOf } from "./cues.js";
import { Fault, FaultCode } from "./faults.js";
import { HeldBytes } from "./held.js";

const mostBytes = 256 << 20; // of one clip that are held while it comes
const tries = 5;
const firstPause = 200; // milliseconds before another try; then twice as long each time
const headBytes = 4096; // that a writer changes when it has finished; where the index is stands in them
const tailBytes = 64 << 10; // in which an index is looked for of which the head says nothing
const mostIndexBytes = 4 << 20;
export const firstBytes = 96 << 10; // that are asked for first: coarse levels, of which a picture can be made

export class ClipSource {
  #held = new HeldBytes();
  #size: number | null = null;
  #all = false;
  #fault: Fault | null = null;
  #waiting: (() => void)[] = [];
  #until = Infinity; // bytes that are asked for
  #from = 0; // what is missing behind this comes before what is missing at all
  #asking: { from: number; cut: AbortController } | null = null; // the request that is being answered
  #ranges: boolean | null = null; // its server gives them; null: it was not asked
  #index: Promise<Cues | null> | null = null;
  #sought: number | null = null; // seconds of the last seek
  #due: { from: number; until: number } | null = null; // bytes that are waited for after a seek
  #urgent = false; // they have come, and nobody has looked at them

  private constructor(
    private readonly url: string | null,
    private readonly signal: AbortSignal,
    private readonly arrived: () => void,
  ) {
    signal.addEventListener("abort", () => this.#wake());
  }

  /** `arrived` is called whenever more has come. What is behind the first bytes comes after `code`: they share a line. */
  static fetched(url: string, signal: AbortSignal, code: Promise<unknown>, arrived: () => void): ClipSource {
    const source = new ClipSource(url, signal, arrived);
    // Servers of other addresses may want to be asked about ranges before.
    if (new URL(url).origin === location.origin) source.#until = firstBytes;
    void source.#fetch(code.catch(() => undefined)); // who needs it says so
    return source;
  }

  static ofFile(file: Blob, signal: AbortSignal): ClipSource {
    const source = new ClipSource(null, signal, () => undefined);
    source.#held.set(file);
    source.#size = file.size;
    source.#all = true;
    return source;
  }

  /** That have come. */
  get bytes(): number {
    return this.#held.bytes;
  }
  /** Of all, null if the server does not say. */
  get size(): number | null {
    return this.#size;
  }
  /** Nothing follows the last byte, so far. */
  get all(): boolean {
    return this.#all;
  }
  /** Why no more comes. */
  get fault(): Fault | null {
    return this.#fault;
  }

  /** What has come: pieces of the file, of which each but the first begins with a cluster, one behind the other. */
  blob(): Blob {
    this.#urgent = false;
    return this.#held.blob();
  }

  /** Until more than so many bytes have come, or what was sought, or no more come. */
  async beyond(bytes: number): Promise<void> {
    while (this.bytes <= bytes && !this.#urgent && !this.#all && !this.#fault && !this.signal.aborted) {
      await new Promise<void>((resolve) => this.#waiting.push(resolve));
    }
  }

  /** What is shown at that time is to come before what lies between, where server and file allow it. */
  async seek(seconds: number): Promise<void> {
    this.#sought = seconds;
    if (!this.url || this.#size === null || this.#all || this.#fault || this.#ranges === false) return;
    const index = await (this.#index ??= this.#readIndex().catch(() => null));
    if (!index || this.#sought !== seconds || this.#all || this.#fault || this.signal.aborted) return;
    const { from, until } = index.placeOf(seconds);
    const end = Math.min(until, this.#size);
    const missing = this.#held.missing(from, end);
    if (!missing) return;
    this.#due = { from, until: end };
    this.#from = from;
    this.#until = Infinity;
    const coming = this.#asking && this.#held.missing(this.#asking.from, this.#size)?.from;
    if (coming !== missing.from) this.#asking?.cut.abort();
  }

  /** Looks whether a file that was all there has grown since. */
  async lookAgain(): Promise<void> {
    if (!this.url || !this.#all) return;
    try {
      const answer = await fetch(this.url, { signal: this.signal, cache: "no-store", headers: range(this.bytes) });
      const size = sizeIn(answer);
      if (answer.status === 416 && size !== null && size < this.bytes) return this.#startAnew(); // another file now
      if (answer.status !== 206) return drop(answer); // nothing new, or all of it again
      if (size !== null && size < this.bytes) {
        drop(answer);
        return this.#startAnew();
      }
      this.#size = size;
      this.#index = null;
      await this.#readHeadAgain();
      await this.#take(answer, this.bytes);
    } catch {
      this.signal.throwIfAborted(); // else it is looked for again
    }
  }

  #startAnew(): void {
    this.#held = new HeldBytes();
    this.#size = null;
    this.#all = false;
    this.#index = null;
    this.#from = 0;
    void this.#fetch(Promise.resolve());
  }

  async #readHeadAgain(): Promise<void> {
    const answer = await fetch(this.url!, { signal: this.signal, cache: "no-store", headers: range(0, headBytes) });
    if (answer.status !== 206) return drop(answer);
    const head = await answer.blob();
    this.#held.set(new Blob([head, this.#held.blob().slice(head.size)]));
  }

  /** null: the file has none, or its server gives no ranges. */
  async #readIndex(): Promise<Cues | null> {
    const size = this.#size!;
    const front = frontOf(new Uint8Array(await this.#held.blob().slice(0, Math.min(headBytes, this.#held.front)).arrayBuffer()));
    if (!front) return null;
    const from = front.cues ?? Math.max(size - tailBytes, 0);
    if (from >= size || size - from > mostIndexBytes) return null;
    const answer = await fetch(this.url!, { signal: this.signal, headers: range(from, size) });
    this.#ranges = answer.status === 206;
    if (!this.#ranges) {
      drop(answer);
      return null;
    }
    return Cues.read(new Uint8Array(await answer.arrayBuffer()), front);
  }

  /** What is to be asked for next. */
  #next(): { from: number; until: number } {
    const size = this.#size ?? Infinity;
    const wanted = this.#from > 0 && this.#ranges ? this.#held.missing(this.#from, size) : null;
    const { from, until } = wanted ?? this.#held.missing(0, size) ?? { from: this.#held.front, until: size };
    return { from, until: Math.min(until === size ? Infinity : until, this.#until) };
  }

  /** Goes on where a connection broke. */
  async #fetch(code: Promise<unknown>): Promise<void> {
    let pause = firstPause;
    for (let left = tries; ; ) {
      const before = this.bytes;
      try {
        await this.#ask();
        if (this.#until < Infinity && !this.#all) {
          this.#until = Infinity;
          await code;
          continue;
        }
        if (this.bytes > before && this.#held.missing(0, this.#size ?? 0)) continue; // what was passed over
        this.#all = true;
      } catch (thrown) {
        if (thrown === cut) continue;
        if (this.bytes > before) [left, pause] = [tries, firstPause];
        if (this.signal.aborted) return;
        if (!(thrown instanceof Fault)) this.#fault = new Fault(FaultCode.decode, String(thrown));
        else if (!(thrown instanceof BrokenConnection) || --left === 0) this.#fault = thrown;
      }
      if (this.#all || this.#fault) return this.#wake();
      await new Promise((resolve) => setTimeout(resolve, pause));
      pause *= 2;
    }
  }

  /** One request. Throws a Fault: BrokenConnection if another try may help; `cut` if something else comes first. */
  async #ask(): Promise<void> {
    const { from, until } = this.#next();
    const controller = new AbortController();
    const end = () => controller.abort();
    this.signal.addEventListener("abort", end);
    this.#asking = { from, cut: controller };
    try {
      await this.#answered(from, until, controller.signal);
    } catch (thrown) {
      throw controller.signal.aborted && !this.signal.aborted ? cut : thrown;
    } finally {
      this.#asking = null;
      this.signal.removeEventListener("abort", end);
    }
  }

  async #answered(from: number, until: number, signal: AbortSignal): Promise<void> {
    let answer: Response;
    const asksForRange = from > 0 || until < Infinity;
    try {
      const headers = asksForRange ? range(from, until) : {};
      answer = await fetch(this.url!, { signal, headers });
    } catch {
      if (this.bytes > 0) throw this.#broken();
      const sentence = `${this.url} cannot be reached, or its server does not let this page read it (CORS)`;
      throw new Fault(FaultCode.network, sentence);
    }
    if (answer.status === 416) return drop(answer); // there is nothing, or no more
    if (answer.status >= 500) {
      drop(answer);
      throw new BrokenConnection(FaultCode.network, `${this.url}: ${said(answer)}`);
    }
    if (!answer.ok || !answer.body) {
      drop(answer);
      throw new Fault(FaultCode.network, `${this.url} is not there: ${said(answer)}`);
    }
    this.#size = sizeIn(answer);
    const part = answer.status === 206;
    if (asksForRange) this.#ranges = part;
    if (!part) this.#until = Infinity; // a server without ranges gives all of it, again
    await this.#take(answer, part ? from : 0);
    if (this.#held.missing(from, Math.min(this.#size ?? 0, part ? until : Infinity))) throw this.#broken();
  }

  /** An answer whose first byte is byte `from` of the file. */
  async #take(answer: Response, from: number): Promise<void> {
    try {
      const reader = answer.body!.getReader();
      for (let at = from; ; ) {
        const { done, value } = await reader.read();
        if (done) break;
        if (this.bytes + value.length > mostBytes) throw this.#tooLarge();
        const before = this.bytes;
        this.#held.add(at, value);
        at += value.length;
        if (this.bytes === before) continue;
        this.#all = this.bytes === this.#size;
        this.#noteDue();
        this.arrived();
        this.#wake();
      }
    } catch (thrown) {
      throw thrown instanceof Fault ? thrown : this.#broken();
    }
  }

  #noteDue(): void {
    if (!this.#due || this.#held.missing(this.#due.from, this.#due.until)) return;
    this.#due = null;
    this.#urgent = true;
  }

  #broken(): BrokenConnection {
    const all = this.#size === null ? "" : ` of ${this.#size}`;
    return new BrokenConnection(FaultCode.network, `${this.url}: the connection ended after ${this.bytes}${all} bytes; load it again`);
  }

  #tooLarge(): Fault {
    return new Fault(FaultCode.notSupported, `${this.url} is larger than ${mostBytes >> 20} MB; cut it with kinora cut`);
  }

  #wake(): void {
    for (const resolve of this.#waiting.splice(0)) resolve();
  }
}

class BrokenConnection extends Fault {}
const cut = Symbol("something else comes first");

/** From byte `from`, up to `until`. */
const range = (from: number, until = Infinity) => ({ Range: `bytes=${from}-${until < Infinity ? until - 1 : ""}` });
const said = (answer: Response) => `the server answers ${answer.status} ${answer.statusText}`;
const drop = (answer: Response) => void answer.body?.cancel().catch(() => undefined); // it may end by itself meanwhile

/** Of the whole file, if the answer says it. */
function sizeIn(answer: Response): number | null {
  const number = (text: string | null | undefined) => (text && Number.isFinite(Number(text)) ? Number(text) : null);
  if (answer.status !== 200) return number(answer.headers.get("Content-Range")?.split("/")[1]);
  // A length that is said of compressed bytes counts others.
  return answer.headers.has("Content-Encoding") ? null : number(answer.headers.get("Content-Length"));
}
