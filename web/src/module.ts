// The player's C interface (include/kinora/player.h) as compiled by web/module, with JavaScript's types.
import createModule, { type KinoraModule } from "kinora-module";
import { fitted, type Camera, type Vector } from "./camera.js";
import { faultOfStatus } from "./faults.js";
import { GpuDrawing } from "./gpu.js";
import { views, type Call, type ClipInfo, type DrawRequest, type Layer, type Opened, type Picture, type Sound, type Span } from "./messages.js";

const cameraNumbers = 22;
const pieceBytes = 1 << 20; // of a file, that are copied at once

export interface Arrived {
  player: ClipPlayer | null; // null: more has to come
  finished: boolean; // nothing will come
  missing: string; // a sentence; empty: nothing is
  end: number; // seconds of the last frame that the file says it has
  come: Span[];
}

export class ClipPlayer {
  private constructor(
    private readonly module: KinoraModule,
    private readonly player: number,
    private readonly gpu: GpuDrawing | null,
  ) {}

  /** What has come of a clip. Throws a Fault if the bytes are no clip. */
  static async open(
    code: WebAssembly.Module,
    file: Blob,
    { name, by, all, firstLook }: Pick<Extract<Call, { kind: "open" }>, "name" | "by" | "all" | "firstLook">,
  ): Promise<Arrived> {
    const module = await createModule({
      instantiateWasm(imports, received) {
        const instance = new WebAssembly.Instance(code, imports);
        received(instance);
        return instance.exports;
      },
    });
    const out = module._malloc(8);
    const text = module._malloc(4 * name.length + 1);
    module.stringToUTF8(name, text, 4 * name.length + 1);
    const clip = module._malloc(Math.max(file.size, 1));
    for (let at = 0; at < file.size; at += pieceBytes) {
      module.HEAPU8.set(new Uint8Array(await file.slice(at, at + pieceBytes).arrayBuffer()), clip + at);
    }
    const status = module._module_open_arrived(clip, file.size, text, Number(all), Number(firstLook), out, out + 4);
    const [player, finished] = [module.HEAPU32[out >> 2]!, module.HEAPU32[(out >> 2) + 1] === 1];
    for (const p of [clip, text, out]) module._free(p);
    const sentence = module.UTF8ToString(module._module_arrived_sentence());
    if (status !== 0) throw faultOfStatus(status, sentence);
    const arrived = { finished, missing: sentence, ...framesOf(module) };
    if (player === 0) return { player: null, ...arrived };
    const soon = firstLook && by !== "webgl"; // shaders take longer to be ready than a first picture
    const gpu = by === "cpu" || soon ? null : GpuDrawing.open(module, by === "webgl");
    return { player: new ClipPlayer(module, player, gpu), ...arrived };
  }

  content({ missing, end, come }: Arrived): Opened["content"] {
    const info = { ...this.info(), missing, end, come };
    return { info, capture: this.captureCamera(info.times[0]!), subject: this.subject(info.times[0]!) };
  }

  private info(): Omit<ClipInfo, "missing" | "end" | "come"> {
    const [frames, , framesPerSecond, layers] = this.doubles(4, (out) => this.module._module_info(this.player, out));
    const times = this.doubles(frames!, (out) => this.module._module_frame_times(this.player, frames!, out));
    const list = Array.from({ length: layers! }, (_, i) => this.layer(i));
    return { times, framesPerSecond: framesPerSecond!, layers: list, hasConfidence: list.some((l) => l.hasConfidence) };
  }

  captureCamera(time: number): Camera {
    const n = this.doubles(cameraNumbers, (out) => this.module._module_capture_camera(this.player, time, out));
    const [width, height, fx, fy, cx, cy] = [n[0]!, n[1]!, n[2]!, n[3]!, n[4]!, n[5]!];
    return { width, height, fx, fy, cx, cy, cameraToWorld: [...n.slice(6)] };
  }

  private subject(time: number): Vector {
    const n = this.doubles(3, (out) => this.module._kinora_player_subject(this.player, time, out));
    return [n[0]!, n[1]!, n[2]!];
  }

  /** `into` holds the picture's bytes if there are as many. */
  draw(request: DrawRequest, into?: ArrayBuffer): Picture {
    const started = performance.now();
    const capture = this.captureCamera(request.time);
    const { width, height, pose, intrinsics } = request.camera;
    const camera = { ...fitted(capture, width, height, pose ?? capture.cameraToWorld), ...intrinsics };
    const m = this.module;
    const pixels = width * height;
    const color = m._malloc(4 * pixels);
    const depth = request.withDepth ? m._malloc(4 * pixels) : 0;
    const visible = m._malloc(Math.max(request.visible.length, 1));
    const numbers = m._malloc(8 * cameraNumbers);
    try {
      m.HEAPU8.set(request.visible.map(Number), visible);
      m.HEAPF64.set(
        [width, height, camera.fx, camera.fy, camera.cx, camera.cy, ...camera.cameraToWorld],
        numbers >> 3,
      );
      const view = views.indexOf(request.view);
      const byGpu = view === 0 && !request.withDepth && this.gpu?.draw(this.player, request.time, numbers, visible, color);
      if (!byGpu) {
        const preview = Number(request.preview);
        this.check(m._module_draw(this.player, request.time, numbers, visible, view, preview, color, depth));
      }
      const bytes = new Uint8ClampedArray(into?.byteLength === 4 * pixels ? into : new ArrayBuffer(4 * pixels));
      bytes.set(m.HEAPU8.subarray(color, color + 4 * pixels));
      return {
        camera,
        color: bytes,
        depth: depth ? m.HEAPF32.slice(depth >> 2, (depth >> 2) + pixels) : null,
        milliseconds: performance.now() - started,
        by: byGpu ? "webgl" : "cpu",
      };
    } finally {
      for (const p of [color, depth, visible, numbers]) m._free(p);
    }
  }

  /** null: it has none. */
  sound(): Sound | null {
    const m = this.module;
    const out = m._malloc(8 * 5);
    try {
      const [codec, setup, setupBytes] = [24, 28, 32].map((at) => out + at) as [number, number, number];
      const count = m._module_sound(this.player, codec, setup, setupBytes, out);
      if (count === 0) return null;
      const word = (at: number) => m.HEAPU32[at >> 2]!;
      const copy = (at: number, size: number) => m.HEAPU8.slice(at, at + size);
      const about = {
        codec: m.UTF8ToString(word(codec)),
        setup: copy(word(setup), word(setupBytes)),
        delay: m.HEAPF64[(out >> 3) + 2]!,
      };
      const [times, ends] = [new Float64Array(count), new Uint32Array(count)];
      const packets: Uint8Array<ArrayBuffer>[] = [];
      let end = 0;
      for (let i = 0; i < count; ++i) {
        const size = m._module_sound_packet(this.player, i, codec, out);
        packets.push(copy(word(codec), size));
        times[i] = m.HEAPF64[out >> 3]!;
        ends[i] = end += size;
      }
      const bytes = new Uint8Array(end);
      packets.forEach((packet, i) => bytes.set(packet, ends[i]! - packet.length));
      return { ...about, times, ends, bytes };
    } finally {
      m._free(out);
    }
  }

  private layer(i: number): Layer {
    const m = this.module;
    const texts = m._malloc(8);
    const hasConfidence = m._module_layer(this.player, i, texts, texts + 4) === 1;
    const text = (at: number) => m.UTF8ToString(m.HEAPU32[at >> 2]!);
    const layer = { name: text(texts), motion: text(texts + 4), hasConfidence };
    m._free(texts);
    return layer;
  }

  private check(status: number): void {
    if (status !== 0) throw faultOfStatus(status, this.module.UTF8ToString(this.module._kinora_player_error()));
  }

  private doubles(count: number, fill: (out: number) => number): Float64Array<ArrayBuffer> {
    const out = this.module._malloc(8 * Math.max(count, 1));
    try {
      this.check(fill(out));
      return this.module.HEAPF64.slice(out >> 3, (out >> 3) + count);
    } finally {
      this.module._free(out);
    }
  }
}

/** Of the clip that was opened last: the time of its last frame, and the spans in which all frames have come. */
function framesOf(m: KinoraModule): Pick<Arrived, "end" | "come"> {
  const count = m._module_arrived_frames(0, 0);
  const seconds = m._malloc(Math.max(9 * count, 1));
  m._module_arrived_frames(seconds, seconds + 8 * count);
  const come: Span[] = [];
  for (let i = 0; i < count; ++i) {
    if (!m.HEAPU8[seconds + 8 * count + i]) continue;
    const time = m.HEAPF64[(seconds >> 3) + i]!;
    if (i > 0 && m.HEAPU8[seconds + 8 * count + i - 1]) come.at(-1)!.to = time;
    else come.push({ from: time, to: time });
  }
  const end = count > 0 ? m.HEAPF64[(seconds >> 3) + count - 1]! : 0;
  m._free(seconds);
  return { end, come };
}
