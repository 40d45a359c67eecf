// The bar below the picture: play, time, menu, full screen.
import { clockText, icon, make } from "./html.js";

export interface ControlActions {
  togglePlay(): void;
  seek(time: number): void;
  fillMenu(menu: HTMLElement): void;
  toggleMuted(): void;
  toggleFullScreen(): void;
}

export class Controls {
  readonly bar: HTMLElement;
  readonly menu = make("div", { class: "menu", id: "menu", role: "group", "aria-label": "Settings", hidden: "" });
  #play = make("button", { type: "button", "aria-label": "Play" }, icon("play"));
  #slider = make("input", { type: "range", "aria-label": "Time", min: "0", max: "0", step: "any", value: "0" });
  #time = make("span", { class: "time" });
  #more = make("button", { type: "button", "aria-label": "Settings", "aria-expanded": "false", "aria-controls": "menu" });

  #sound = make("button", { type: "button", "aria-label": "Mute", hidden: "" }, icon("sound"));

  constructor(private readonly actions: ControlActions) {
    this.#more.append(icon("menu"));
    const full = make("button", { type: "button", "aria-label": "Full screen" }, icon("full"));
    this.bar = make("div", { class: "bar", role: "group", "aria-label": "Controls" });
    this.bar.append(this.#play, this.#slider, this.#time, this.#sound, this.#more, full);
    this.#play.addEventListener("click", () => actions.togglePlay());
    this.#slider.addEventListener("input", () => actions.seek(Number(this.#slider.value)));
    this.#more.addEventListener("click", () => this.openMenu(this.menu.hidden !== false));
    this.#sound.addEventListener("click", () => actions.toggleMuted());
    full.addEventListener("click", () => actions.toggleFullScreen());
    this.menu.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      this.openMenu(false);
      this.#more.focus();
    });
  }

  openMenu(open: boolean): void {
    if (open) this.actions.fillMenu(this.menu);
    this.menu.hidden = !open;
    this.#more.setAttribute("aria-expanded", String(open));
    if (open) this.menu.querySelector("input")?.focus();
  }

  /** What it offers has changed. */
  refillMenu(): void {
    if (!this.menu.hidden && !this.menu.matches(":focus-within")) this.actions.fillMenu(this.menu);
  }

  setPlaying(playing: boolean): void {
    this.#play.setAttribute("aria-label", playing ? "Pause" : "Play");
    this.#play.replaceChildren(icon(playing ? "pause" : "play"));
  }

  setSound(there: boolean, muted: boolean): void {
    this.#sound.hidden = !there;
    this.#sound.setAttribute("aria-label", muted ? "Unmute" : "Mute");
    this.#sound.replaceChildren(icon(muted ? "muted" : "sound"));
  }

  setTime(time: number, start: number, end: number): void {
    this.#slider.min = String(start);
    this.#slider.max = String(end);
    this.#slider.value = String(time);
    const text = `${clockText(time - start)} / ${clockText(end - start)}`;
    if (this.#time.textContent === text) return;
    this.#time.textContent = text;
    this.#slider.setAttribute("aria-valuetext", `${clockText(time - start)} of ${clockText(end - start)}`);
  }
}
