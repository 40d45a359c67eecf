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
  const bytes = answer?.ok ? await answer.arrayBuffer().catch(() => null) : null;
  if (!bytes) throw new Fault(FaultCode.network, `${address.href}, which plays clips, cannot be loaded`);
  return WebAssembly.compile(bytes);
}
