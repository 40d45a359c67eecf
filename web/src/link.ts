// The part of an address that says when and from where: #t=2.4&cam=… (position, target and up, nine numbers).
import { isView, type Vector, type View } from "./camera.js";

export interface Place {
  time?: number;
  view?: View;
}

export function parsePlace(hash: string): Place {
  const words = new URLSearchParams(hash.replace(/^#/, ""));
  const place: Place = {};
  const time = Number(words.get("t") ?? NaN);
  if (Number.isFinite(time) && time >= 0) place.time = time;
  const n = (words.get("cam") ?? "").split(",").map(Number);
  const view: View = { position: n.slice(0, 3) as Vector, target: n.slice(3, 6) as Vector, up: n.slice(6) as Vector };
  if (n.length === 9 && isView(view)) place.view = view;
  return place;
}

export function formatPlace(time: number, view: View | null): string {
  const text = (x: number) => String(Number(x.toFixed(4)));
  const camera = view ? `&cam=${[...view.position, ...view.target, ...view.up].map(text).join(",")}` : "";
  return `#t=${text(time)}${camera}`;
}
