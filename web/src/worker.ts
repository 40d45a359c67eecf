// The worker: one clip, decoded and drawn beside the page's own thread.
import { asFault, Fault, FaultCode } from "./faults.js";
import { ClipPlayer } from "./module.js";
import type { Answer, Call, Opened, Picture, Question, Results } from "./messages.js";

let player: ClipPlayer | null = null;
async function open({ code, clip, name, by, all, firstLook }: Extract<Call, { kind: "open" }>): Promise<Opened> {
  const opened = await ClipPlayer.open(code, clip, { name, by, all, firstLook });
  player = opened.player;
  return { finished: opened.finished && !firstLook, content: player && player.content(opened) };
}

async function answerTo(call: Call): Promise<Results[keyof Results]> {
  if (call.kind === "open") return open(call);
  if (!player) throw new Fault(FaultCode.aborted, "no clip is open");
  if (call.kind === "captureCamera") return player.captureCamera(call.time);
  if (call.kind === "sound") return player.sound();
  return player.draw(call.request, call.into);
}

function send(answer: Answer): void {
  const picture = ("result" in answer && (answer.result as Partial<Picture> | null)) || {};
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
