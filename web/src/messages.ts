// What the page and its worker say to each other.
import type { Camera, Vector } from "./camera.js";

export interface Layer {
  name: string;
  motion: string; // still, rigid, deforming
  hasConfidence: boolean;
}

/** Seconds of its first and its last frame. */
export interface Span {
  from: number;
  to: number;
}

export interface ClipInfo {
  times: Float64Array; // of the frames up to the last that has come, seconds
  end: number; // seconds of the last frame of all
  come: Span[]; // in which all frames have come, in order
  framesPerSecond: number;
  layers: Layer[];
  hasConfidence: boolean;
  missing: string; // a sentence; empty: nothing is
}

/** A clip's sound as its file has it. */
export interface Sound {
  codec: string; // Matroska's name
  setup: Uint8Array; // the codec's private data
  delay: number; // seconds that its decoder delays
  times: Float64Array; // of the packets, as those of frames
  ends: Uint32Array; // of the packets in `bytes`
  bytes: Uint8Array;
}

/** What opening gives. */
export interface Opened {
  content: { info: ClipInfo; capture: Camera; subject: Vector } | null; // null: more has to come
  finished: boolean; // nothing will come
}

export const views = ["color", "depth", "normal", "confidence", "health"] as const; // as KinoraPlayerView
export type ViewName = (typeof views)[number];

export interface WantedCamera {
  pose: number[] | null; // camera to world; null: where the capture's camera was
  width: number;
  height: number;
  intrinsics?: Pick<Camera, "fx" | "fy" | "cx" | "cy">; // without: the capture's picture fits in
}

export interface DrawRequest {
  time: number;
  camera: WantedCamera;
  visible: boolean[];
  view: ViewName;
  preview: boolean; // one sample to a pixel
  withDepth: boolean;
}

export interface Picture {
  camera: Camera;
  color: Uint8ClampedArray<ArrayBuffer>; // sRGB and straight alpha
  depth: Float32Array<ArrayBuffer> | null; // metres; 0: nothing
  milliseconds: number;
  by: "cpu" | "webgl";
}

/** Who draws: the GPU where there is one that draws faster than the CPU; the CPU; WebGL in any case. */
export type DrawnBy = "auto" | "cpu" | "webgl";

export type Call =
  | { kind: "open"; code: WebAssembly.Module; clip: Blob; name: string; by: DrawnBy; all: boolean; firstLook: boolean } // all: nothing follows now; firstLook: soon and coarse
  | { kind: "captureCamera"; time: number }
  | { kind: "sound" }
  | { kind: "draw"; request: DrawRequest; into?: ArrayBuffer | undefined }; // into: of a picture that nobody needs any more

export interface Results {
  open: Opened;
  captureCamera: Camera;
  sound: Sound | null;
  draw: Picture;
}

export interface Question {
  id: number;
  call: Call;
}

export type Answer =
  | { id: number; result: Results[keyof Results] }
  | { id: number; fault: { code: number; message: string } };
