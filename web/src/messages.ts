// What the page and its worker say to each other.
import type { Camera, Vector } from "./camera.js";

export interface Layer {
  name: string;
  motion: string; // still, rigid, deforming
  hasConfidence: boolean;
}

export interface ClipInfo {
  times: Float64Array; // of the frames, seconds
  framesPerSecond: number;
  layers: Layer[];
  hasConfidence: boolean;
}

export const views = ["color", "depth", "normal", "confidence"] as const;
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
  | { kind: "open"; clip: Blob; name: string; by: DrawnBy }
  | { kind: "subject"; time: number }
  | { kind: "captureCamera"; time: number }
  | { kind: "draw"; request: DrawRequest };

export interface Results {
  open: ClipInfo;
  subject: Vector;
  captureCamera: Camera;
  draw: Picture;
}

export interface Question {
  id: number;
  call: Call;
}

export type Answer =
  | { id: number; result: Results[keyof Results] }
  | { id: number; fault: { code: number; message: string } };
