// The package: importing it makes <kinora-player> known.
import { KinoraPlayerElement } from "./element.js";

export { KinoraPlayerElement };
export { FaultCode } from "./faults.js";
export { parsePlace } from "./link.js";
export type { Camera, Vector, View } from "./camera.js";
export type { ClipInfo, Layer, ViewName } from "./messages.js";

if (!customElements.get("kinora-player")) customElements.define("kinora-player", KinoraPlayerElement);

declare global {
  interface HTMLElementTagNameMap {
    "kinora-player": KinoraPlayerElement;
  }
}
