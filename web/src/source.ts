// The bytes of a clip, from the first on, as they come: over a network, or out of a file of this machine.
import { Fault, FaultCode } from "./faults.js";

const mostBytes = 256 << 20; // of one clip that are held while it comes
const tries = 5;
const firstPause = 200; // milliseconds before another try; then twice as long each time
const headBytes = 4096; // that a writer changes when it has finished
const firstBytes = 96 << 10; // that are asked for first: coarse levels, of which a picture can be made

export class ClipSource {
  #come = new Blob();
  #fresh: Uint8Array<ArrayBuffer>[] = []; // behind #come
  #bytes = 0;
  #size: number | null = null;
  #all = false;
  #fault: Fault | null = null;
  #waiting: (() => void)[] = [];
  #until = Infinity; // bytes that are asked for

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
    source.#come = file;
    source.#bytes = source.#size = file.size;
    source.#all = true;
    return source;
  }

  /** That have come. */
  get bytes(): number {
    return this.#bytes;
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

  /** What has come. */
  blob(): Blob {
    if (this.#fresh.length > 0) this.#come = new Blob([this.#come, ...this.#fresh]);
    this.#fresh = [];
    return this.#come;
  }

  /** Until more than so many bytes have come, or no more come. */
  async beyond(bytes: number): Promise<void> {
    while (this.#bytes <= bytes && !this.#all && !this.#fault && !this.signal.aborted) {
      await new Promise<void>((resolve) => this.#waiting.push(resolve));
    }
  }

  /** Looks whether a file that was all there has grown since. */
  async lookAgain(): Promise<void> {
    if (!this.url || !this.#all) return;
    try {
      const answer = await fetch(this.url, { signal: this.signal, cache: "no-store", headers: range(this.#bytes) });
      const size = sizeIn(answer);
      if (answer.status === 416 && size !== null && size < this.#bytes) return this.#startAnew(); // another file now
      if (answer.status !== 206) return void answer.body?.cancel(); // nothing new, or all of it again
      if (size !== null && size < this.#bytes) return this.#startAnew();
      this.#size = size;
      await this.#readHeadAgain();
      await this.#take(answer, 0);
    } catch {
      this.signal.throwIfAborted(); // else it is looked for again
    }
  }

  #startAnew(): void {
    this.#come = new Blob();
    this.#fresh = [];
    this.#bytes = 0;
    this.#size = null;
    this.#all = false;
    void this.#fetch(Promise.resolve());
  }

  async #readHeadAgain(): Promise<void> {
    const answer = await fetch(this.url!, { signal: this.signal, cache: "no-store", headers: range(0, headBytes) });
    if (answer.status !== 206) return;
    const head = await answer.blob();
    this.#come = new Blob([head, this.blob().slice(head.size)]);
  }

  /** Goes on where a connection broke. */
  async #fetch(code: Promise<unknown>): Promise<void> {
    let pause = firstPause;
    for (let left = tries; ; ) {
      const before = this.#bytes;
      try {
        await this.#ask();
        if (this.#until < Infinity && !this.#all) {
          this.#until = Infinity;
          await code;
          continue;
        }
        this.#all = true;
      } catch (thrown) {
        if (this.#bytes > before) [left, pause] = [tries, firstPause];
        if (this.signal.aborted) return;
        if (!(thrown instanceof Fault)) this.#fault = new Fault(FaultCode.decode, String(thrown));
        else if (!(thrown instanceof BrokenConnection) || --left === 0) this.#fault = thrown;
      }
      if (this.#all || this.#fault) return this.#wake();
      await new Promise((resolve) => setTimeout(resolve, pause));
      pause *= 2;
    }
  }

  /** One request. Throws a Fault: BrokenConnection if another try may help. */
  async #ask(): Promise<void> {
    const had = this.#bytes;
    let answer: Response;
    try {
      const headers = had > 0 || this.#until < Infinity ? range(had, this.#until) : {};
      answer = await fetch(this.url!, { signal: this.signal, headers });
    } catch {
      if (had > 0) throw this.#broken();
      const sentence = `${this.url} cannot be reached, or its server does not let this page read it (CORS)`;
      throw new Fault(FaultCode.network, sentence);
    }
    if (answer.status === 416) return; // there is nothing, or no more
    if (answer.status >= 500) throw new BrokenConnection(FaultCode.network, `${this.url}: ${said(answer)}`);
    if (!answer.ok || !answer.body) throw new Fault(FaultCode.network, `${this.url} is not there: ${said(answer)}`);
    this.#size = sizeIn(answer);
    if (answer.status !== 206) this.#until = Infinity; // a server without ranges gives all of it, again
    await this.#take(answer, answer.status === 206 ? 0 : had);
  }

  async #take(answer: Response, known: number): Promise<void> {
    try {
      const reader = answer.body!.getReader();
      for (let passed = 0; ; ) {
        const { done, value } = await reader.read();
        if (done) break;
        const skipped = Math.min(Math.max(known - passed, 0), value.length);
        passed += value.length;
        if (skipped === value.length) continue;
        if (this.#bytes + value.length > mostBytes) throw this.#tooLarge();
        this.#fresh.push(value.subarray(skipped));
        this.#bytes += value.length - skipped;
        this.#all = this.#bytes === this.#size;
        this.arrived();
        this.#wake();
      }
    } catch (thrown) {
      throw thrown instanceof Fault ? thrown : this.#broken();
    }
    if (this.#bytes < Math.min(this.#size ?? 0, this.#until)) throw this.#broken();
  }

  #broken(): BrokenConnection {
    const all = this.#size === null ? "" : ` of ${this.#size}`;
    return new BrokenConnection(FaultCode.network, `${this.url}: the connection ended after ${this.#bytes}${all} bytes; load it again`);
  }

  #tooLarge(): Fault {
    return new Fault(FaultCode.notSupported, `${this.url} is larger than ${mostBytes >> 20} MB; cut it with kinora cut`);
  }

  #wake(): void {
    for (const resolve of this.#waiting.splice(0)) resolve();
  }
}

class BrokenConnection extends Fault {}

/** From byte `from`, up to `until`. */
const range = (from: number, until = Infinity) => ({ Range: `bytes=${from}-${until < Infinity ? until - 1 : ""}` });
const said = (answer: Response) => `the server answers ${answer.status} ${answer.statusText}`;

/** Of the whole file, if the answer says it. */
function sizeIn(answer: Response): number | null {
  const number = (text: string | null | undefined) => (text && Number.isFinite(Number(text)) ? Number(text) : null);
  if (answer.status !== 200) return number(answer.headers.get("Content-Range")?.split("/")[1]);
  // A length that is said of compressed bytes counts others.
  return answer.headers.has("Content-Encoding") ? null : number(answer.headers.get("Content-Length"));
}
