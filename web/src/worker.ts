// The worker: one clip, decoded and drawn beside the page's own thread.
import { asFault, Fault, FaultCode } from "./faults.js";
import { ClipPlayer } from "./module.js";
import type { Answer, Call, ClipInfo, DrawnBy, Picture, Question, Results } from "./messages.js";

let player: ClipPlayer | null = null;
// Comes while the clip does.
const address = new URL("kinora-player.wasm", import.meta.url);
const wasm = fetch(address).then(
  (answer) => (answer.ok ? answer.arrayBuffer() : null),
  () => null,
);

async function open(clip: Blob, name: string, by: DrawnBy): Promise<ClipInfo> {
  const code = await wasm;
  if (!code) throw new Fault(FaultCode.network, `${address.href}, which plays clips, cannot be loaded`);
  player = await ClipPlayer.open(code, await clip.arrayBuffer(), name, by);
  return player.info();
}

async function answerTo(call: Call): Promise<Results[keyof Results]> {
  if (call.kind === "open") return open(call.clip, call.name, call.by);
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
