// The page that plays one clip: index.html?clip=ADDRESS#t=…&cam=…
import { KinoraPlayerElement } from "./element.js";
import { parsePlace } from "./link.js";
import "./index.js";

const player = document.querySelector<KinoraPlayerElement>("kinora-player")!;

function goTo(hash: string): void {
  const { time, view } = parsePlace(hash);
  if (time !== undefined) {
    player.autoplay = false; // whoever was sent here was sent to this moment
    player.pause();
    player.currentTime = time;
  }
  if (view) player.camera = view;
}

goTo(location.hash);
addEventListener("hashchange", () => goTo(location.hash));
const clip = new URLSearchParams(location.search).get("clip");
if (clip) {
  document.title = `${clip.split("/").pop()} · Kinora`;
  player.src = clip;
}
