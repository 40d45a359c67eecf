// The bytes of a clip: fetched, and counted while they come.
import { Fault, FaultCode } from "./faults.js";

export type Arrived = (bytes: number, ofBytes: number | null) => void;

/** Rejects with a Fault: the address does not answer, answers with an error, or ends before the clip does. */
export async function fetchClip(url: string, signal: AbortSignal, arrived: Arrived): Promise<Blob> {
  let answer: Response;
  try {
    answer = await fetch(url, { signal });
  } catch {
    signal.throwIfAborted();
    throw new Fault(FaultCode.network, `${url} cannot be reached, or its server does not let this page read it (CORS)`);
  }
  if (!answer.ok || !answer.body) {
    throw new Fault(FaultCode.network, `${url} is not there: the server answers ${answer.status} ${answer.statusText}`);
  }
  const stated = Number(answer.headers.get("Content-Length") ?? NaN);
  // A length that is said of compressed bytes counts others.
  const size = Number.isFinite(stated) && !answer.headers.has("Content-Encoding") ? stated : null;
  const pieces: Uint8Array<ArrayBuffer>[] = [];
  let bytes = 0;
  try {
    const reader = answer.body.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      pieces.push(value);
      bytes += value.length;
      arrived(bytes, size);
    }
  } catch {
    signal.throwIfAborted();
    throw new Fault(FaultCode.network, `${url}: the connection ended after ${bytes} bytes; load it again`);
  }
  if (size !== null && bytes < size) {
    throw new Fault(FaultCode.network, `${url}: the connection ended after ${bytes} of ${size} bytes; load it again`);
  }
  return new Blob(pieces);
}
