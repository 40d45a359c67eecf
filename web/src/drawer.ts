// One worker as the page sees it: calls that answer later.
import { Fault, FaultCode } from "./faults.js";
import type { Answer, Call, Question, Results } from "./messages.js";

type Waiting = { resolve: (result: never) => void; reject: (fault: Fault) => void };

export class Drawer {
  #worker: Worker;
  #waiting = new Map<number, Waiting>();
  #next = 0;
  #retired = false;

  constructor() {
    this.#worker = startWorker(new URL("kinora-worker.js", import.meta.url));
    this.#worker.onmessage = ({ data }: MessageEvent<Answer>) => {
      const waiting = this.#waiting.get(data.id);
      this.#waiting.delete(data.id);
      if ("result" in data) waiting?.resolve(data.result as never);
      else waiting?.reject(new Fault(data.fault.code as FaultCode, data.fault.message));
      if (this.#retired && !this.busy) this.close();
    };
    this.#worker.onerror = (event) => {
      event.preventDefault();
      this.#end(new Fault(FaultCode.decode, `the worker that draws ended: ${event.message || "it cannot be loaded"}`));
    };
  }

  get busy(): boolean {
    return this.#waiting.size > 0;
  }

  /** What is in `moved` goes over and is here no more. */
  ask<Kind extends Call["kind"]>(call: Extract<Call, { kind: Kind }>, moved: Transferable[] = []): Promise<Results[Kind]> {
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, call } satisfies Question, moved);
    });
  }

  /** When all that was asked has been answered. */
  retire(): void {
    this.#retired = true;
    if (!this.busy) this.close();
  }

  close(): void {
    this.#worker.terminate();
    this.#end(new Fault(FaultCode.aborted, "the clip was closed"));
  }

  #end(fault: Fault): void {
    for (const { reject } of this.#waiting.values()) reject(fault);
    this.#waiting.clear();
  }
}

/** A worker of another address than the page's starts from a file that imports it. */
function startWorker(url: URL): Worker {
  if (url.origin === location.origin) return new Worker(url, { type: "module" });
  const file = new Blob([`import ${JSON.stringify(url.href)};`], { type: "text/javascript" });
  return new Worker(URL.createObjectURL(file), { type: "module" });
}
