// The worker: one clip, decoded and drawn beside the page's own thread.
import { asFault, Fault, FaultCode } from "./faults.js";
import { ClipPlayer } from "./module.js";
import type { Answer, Call, ClipInfo, Picture, Question, Results } from "./messages.js";

let player: ClipPlayer | null = null;

async function open(clip: Blob, name: string): Promise<ClipInfo> {
  const address = new URL("kinora-player.wasm", import.meta.url);
  const answer = await fetch(address).catch(() => null);
  if (!answer?.ok) throw new Fault(FaultCode.network, `${address.href}, which plays clips, cannot be loaded`);
  player = await ClipPlayer.open(await answer.arrayBuffer(), await clip.arrayBuffer(), name);
  return player.info();
}

async function answerTo(call: Call): Promise<Results[keyof Results]> {
  if (call.kind === "open") return open(call.clip, call.name);
  if (!player) throw new Fault(FaultCode.aborted, "no clip is open");
  if (call.kind === "subject") return player.subject(call.time);
  if (call.kind === "captureCamera") return player.captureCamera(call.time);
  return player.draw(call.request);
}

function send(answer: Answer): void {
  const picture = "result" in answer ? (answer.result as Partial<Picture>) : {};
  const moved = [picture.color?.buffer, picture.depth?.buffer].filter((b): b is ArrayBuffer => b !== undefined);
  self.postMessage(answer, { transfer: moved });
}

self.onmessage = async ({ data: { id, call } }: MessageEvent<Question>) => {
  try {
    send({ id, result: await answerTo(call) });
  } catch (thrown) {
    const fault = asFault(thrown);
    send({ id, fault: { code: fault.code, message: fault.message } });
  }
};
