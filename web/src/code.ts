// The player's code as WebAssembly: fetched and compiled once for all workers, while a clip comes.
import { Fault, FaultCode } from "./faults.js";

const address = new URL("kinora-player.wasm", import.meta.url);
let compiled: Promise<WebAssembly.Module> | null = null;

/** Rejects with a Fault; the next call tries again. */
export function playerCode(): Promise<WebAssembly.Module> {
  compiled ??= load().catch((thrown: unknown) => {
    compiled = null;
    throw thrown;
  });
  return compiled;
}

async function load(): Promise<WebAssembly.Module> {
  const answer = await fetch(address).catch(() => null);
  if (!answer?.ok) lost();
  // While it comes, if its server says what it is.
  if (answer.headers.get("Content-Type") === "application/wasm") return WebAssembly.compileStreaming(answer).catch(lost);
  return answer.arrayBuffer().then((bytes) => WebAssembly.compile(bytes), lost);
}

function lost(): never {
  throw new Fault(FaultCode.network, `${address.href}, which plays clips, cannot be loaded`);
}
