// The menu: layers, what is shown, speed, and what is done now and then.
import { make } from "./html.js";
import { views, type ClipInfo, type ViewName } from "./messages.js";

export interface MenuActions {
  setLayer(layer: number, visible: boolean): void;
  setView(view: ViewName): void;
  setRate(rate: number): void;
  setLoop(loop: boolean): void;
  resetCamera(): void;
  copyLink(): void;
  chooseFile(): void;
}

const titles: Record<ViewName, string> = { color: "Colour", depth: "Depth", normal: "Normals", confidence: "Confidence", health: "Tracking" };

export interface MenuState {
  layers: readonly boolean[];
  view: ViewName;
  rate: number;
  loop: boolean;
}

export function makeMenu(info: ClipInfo, state: MenuState, actions: MenuActions): HTMLElement[] {
  const layers = info.layers.map((layer, i) => {
    const box = make("input", { type: "checkbox" });
    box.checked = state.layers[i]!;
    box.addEventListener("change", () => actions.setLayer(i, box.checked));
    return make("label", {}, box, layer.name);
  });
  const shown = views.filter((view) => view !== "confidence" || info.hasConfidence);
  const choices = shown.map((view) => {
    const box = make("input", { type: "radio", name: "view" });
    box.checked = view === state.view;
    box.addEventListener("change", () => actions.setView(view));
    return make("label", {}, box, titles[view]);
  });
  const speed = make("select");
  const rates = [...new Set([0.25, 0.5, 1, 2, state.rate])].sort((a, b) => a - b);
  for (const rate of rates) speed.append(make("option", { value: String(rate) }, `${rate}×`));
  speed.value = String(state.rate);
  speed.addEventListener("change", () => actions.setRate(Number(speed.value)));
  const loop = make("input", { type: "checkbox" });
  loop.checked = state.loop;
  loop.addEventListener("change", () => actions.setLoop(loop.checked));

  const button = (text: string, action: () => void) => {
    const made = make("button", { type: "button" }, text);
    made.addEventListener("click", action);
    return made;
  };
  return [
    make("fieldset", {}, make("legend", {}, "Layers"), ...layers),
    make("fieldset", {}, make("legend", {}, "Shown"), ...choices),
    make("fieldset", {}, make("label", {}, "Speed", speed), make("label", {}, loop, "Repeat")),
    button("The camera's own view", () => actions.resetCamera()),
    button("Copy a link to this view", () => actions.copyLink()),
    button("Open a file…", () => actions.chooseFile()),
  ];
}
