// A camera that people turn: where it stands, what it looks at, and which way is up. Metres, world coordinates of the clip.

export type Vector = [number, number, number];

/** `target` lies on the optical axis; `up` need not be perpendicular to it. */
export interface View {
  position: Vector;
  target: Vector;
  up: Vector;
}

/** Pinhole camera; pixel centres at integer coordinates. `cameraToWorld`: 4x4 row by row, x right, y down, z forward. */
export interface Camera {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  cameraToWorld: number[];
}

const add = (a: Vector, b: Vector, scale = 1): Vector => [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]];
const subtract = (a: Vector, b: Vector): Vector => add(a, b, -1);
const dot = (a: Vector, b: Vector): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Vector, b: Vector): Vector => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const scaled = (a: Vector, scale: number): Vector => [scale * a[0], scale * a[1], scale * a[2]];
const length = (a: Vector): number => Math.sqrt(dot(a, a));
const normalized = (a: Vector): Vector => scaled(a, 1 / length(a));
const clamp = (x: number, low: number, high: number): number => Math.min(Math.max(x, low), high);

/** Rodrigues' formula; `axis` is a unit vector. */
function rotated(a: Vector, axis: Vector, radians: number): Vector {
  const c = Math.cos(radians);
  const s = Math.sin(radians);
  return add(add(scaled(a, c), cross(axis, a), s), axis, dot(axis, a) * (1 - c));
}

/** The camera's axes in the world: right, down, forward. */
function axes(view: View): [Vector, Vector, Vector] {
  const forward = normalized(subtract(view.target, view.position));
  const right = normalized(cross(forward, view.up));
  return [right, cross(forward, right), forward];
}

export function isView(view: View): boolean {
  const numbers = [...view.position, ...view.target, ...view.up];
  if (numbers.length !== 9 || !numbers.every(Number.isFinite)) return false;
  return length(cross(subtract(view.target, view.position), view.up)) > 1e-9;
}

export function poseOf(view: View): number[] {
  const [x, y, z] = axes(view);
  const p = view.position;
  return [x[0], y[0], z[0], p[0], x[1], y[1], z[1], p[1], x[2], y[2], z[2], p[2], 0, 0, 0, 1];
}

/** The view of a camera, with its target beside `subject`: as far ahead. */
export function viewOf(pose: readonly number[], subject: Vector): View {
  const column = (i: number): Vector => [pose[i]!, pose[4 + i]!, pose[8 + i]!];
  const position = column(3);
  const ahead = Math.max(dot(subtract(subject, position), column(2)), 0.1);
  return { position, target: add(position, column(2), ahead), up: scaled(column(1), -1) };
}

/** A drag by parts of the picture's height: over the whole of it turns by half a circle, never over the poles. */
export function orbited(view: View, right: number, down: number): View {
  const pole = 0.05; // radians
  const up = normalized(view.up);
  const [x, , forward] = axes(view);
  const toUp = Math.acos(clamp(dot(forward, up), -1, 1));
  const tilt = clamp(toUp + Math.PI * down, pole, Math.PI - pole) - toUp;
  const turn = (a: Vector): Vector => rotated(rotated(a, x, -tilt), up, -Math.PI * right);
  return { ...view, position: add(view.target, turn(subtract(view.position, view.target))) };
}

/** What lies as far away as the target follows the pointer. `height`: of the picture at distance 1. */
export function panned(view: View, right: number, down: number, height: number): View {
  const [x, y] = axes(view);
  const distance = length(subtract(view.target, view.position)) * height;
  const step = add(scaled(x, -right * distance), y, -down * distance);
  return { ...view, position: add(view.position, step), target: add(view.target, step) };
}

/** The distance to the target times `factor`. */
export function zoomed(view: View, factor: number): View {
  const away = subtract(view.position, view.target);
  const distance = clamp(length(away) * factor, 0.05, 100);
  return { ...view, position: add(view.target, scaled(normalized(away), distance)) };
}

/** The capture's picture as large as it fits into width x height, in the middle; what is beside it shows more. */
export function fitted(capture: Camera, width: number, height: number, pose: number[]): Camera {
  const scale = Math.min(width / capture.width, height / capture.height);
  const [w, h] = [scale * capture.width, scale * capture.height];
  return {
    width,
    height,
    fx: capture.fx * scale,
    fy: capture.fy * scale,
    cx: (capture.cx + 0.5) * scale - 0.5 + (width - w) / 2,
    cy: (capture.cy + 0.5) * scale - 0.5 + (height - h) / 2,
    cameraToWorld: pose,
  };
}
