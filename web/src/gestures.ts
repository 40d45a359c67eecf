// Pointers, wheel and keys that turn the camera: one pointer turns, two (or a right or shift drag) move and come nearer.
import { orbited, panned, zoomed, type View } from "./camera.js";

export interface Turned {
  view(): View | null; // now; null: there is none yet
  turn(view: View): void;
  heightAtOne(): number; // of the picture, metres at one metre
}

interface Point {
  x: number;
  y: number;
}

export function listenToPointers(area: HTMLElement, turned: Turned): void {
  const pointers = new Map<number, Point>();
  const change = (how: (view: View) => View) => {
    const view = turned.view();
    if (view) turned.turn(how(view));
  };

  area.addEventListener("pointerdown", (event) => {
    area.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  area.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    pointers.set(event.pointerId, now);
    const height = area.clientHeight || 1;
    const [right, down] = [(now.x - before.x) / height, (now.y - before.y) / height];
    if (other) {
      const [was, is] = [distance(before, other), distance(now, other)];
      // Each of two fingers moves the point between them by half of its own way.
      change((view) => {
        const moved = panned(view, right / 2, down / 2, turned.heightAtOne());
        return is > 0 ? zoomed(moved, was / is) : moved;
      });
    } else if (event.shiftKey || event.buttons & 6) {
      change((view) => panned(view, right, down, turned.heightAtOne()));
    } else {
      change((view) => orbited(view, right, down));
    }
  });
  for (const end of ["pointerup", "pointercancel"] as const) {
    area.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
  area.addEventListener("contextmenu", (event) => event.preventDefault());
  area.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / 100 : event.deltaY / 3;
      change((view) => zoomed(view, Math.pow(1.1, lines)));
    },
    { passive: false },
  );
}

const distance = (a: Point, b: Point): number => Math.hypot(a.x - b.x, a.y - b.y);

/** The view after a key, or null if the key does not turn the camera. */
export function viewAfterKey(event: KeyboardEvent, view: View): View | null {
  const step = 1 / 24; // of the height: 7.5 degrees
  if (event.key === "+" || event.key === "=") return zoomed(view, 0.9);
  if (event.key === "-") return zoomed(view, 1 / 0.9);
  if (!event.shiftKey) return null;
  if (event.key === "ArrowLeft") return orbited(view, -step, 0);
  if (event.key === "ArrowRight") return orbited(view, step, 0);
  if (event.key === "ArrowUp") return orbited(view, 0, -step);
  if (event.key === "ArrowDown") return orbited(view, 0, step);
  return null;
}
