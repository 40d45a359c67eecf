// What the element shows: the picture, what lies over it, and messages.
import { make } from "./html.js";
import { style } from "./style.js";

export class Surface {
  readonly canvas = make("canvas", { part: "picture" });
  readonly stage = make("div", { class: "stage", tabindex: "0", role: "application", "aria-label": "Volumetric video" });
  readonly file = make("input", { type: "file", accept: ".mkv,video/x-matroska", hidden: "" });
  #poster = make("img", { class: "poster", alt: "", hidden: "" });
  #text = make("span");
  #state = make("div", { class: "state", role: "status", hidden: "" }, make("span", { class: "spinner" }), this.#text);
  #empty = make("button", { type: "button", class: "empty", hidden: "" }, "Open a clip, or drop one here");
  #fault = make("div", { class: "fault", role: "alert", hidden: "" });

  constructor(root: ShadowRoot) {
    this.stage.setAttribute("aria-roledescription", "volumetric video: drag, or shift and arrow keys, to turn");
    this.stage.append(this.canvas, this.#poster);
    root.append(make("style", {}, style), this.stage, this.#state, this.#fault, this.#empty, this.file);
    this.#empty.addEventListener("click", () => this.file.click());
  }

  setPoster(address: string): void {
    this.#poster.hidden = address === "";
    if (address) this.#poster.src = address;
    else this.#poster.removeAttribute("src");
  }

  /** null: nothing is waited for. */
  setState(text: string | null): void {
    this.#state.hidden = text === null;
    this.#text.textContent = text;
  }

  /** null: nothing is wrong. With `beside` the picture stays to be seen. */
  setFault(message: string | null, beside = false): void {
    this.#fault.hidden = message === null;
    this.#fault.classList.toggle("beside", beside);
    this.#fault.textContent = message;
  }

  /** There is nothing to show: asks for a file. */
  setEmpty(empty: boolean): void {
    this.#empty.hidden = !empty;
  }

  clear(): void {
    this.canvas.width = this.canvas.height = 1;
    this.setState(null);
    this.setFault(null);
  }
}

export function stateOfArrival(bytes: number, size: number | null): string {
  const megabytes = (count: number) => (count / 1e6).toFixed(1);
  return size === null ? `Loading: ${megabytes(bytes)} MB` : `Loading: ${megabytes(bytes)} of ${megabytes(size)} MB`;
}
