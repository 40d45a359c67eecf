// How large pictures may be while something moves, so that they keep up.

export interface Size {
  width: number;
  height: number;
}

/** The smallest that is drawn on purpose. */
const fewestPixels = 320 * 240;

export class Resolution {
  #millisecondsPerPixel = 0;
  #pixels = fewestPixels;

  /** `budget`: milliseconds that one picture may take. */
  constructor(private readonly budget: number) {}

  drawn(size: Size, milliseconds: number): void {
    const cost = milliseconds / (size.width * size.height);
    const known = this.#millisecondsPerPixel;
    this.#millisecondsPerPixel = known === 0 ? cost : 0.8 * known + 0.2 * cost;
    const affordable = Math.max(this.budget / this.#millisecondsPerPixel, fewestPixels);
    // Small changes are not worth a picture of another sharpness.
    if (affordable < 0.8 * this.#pixels || affordable > 1.5 * this.#pixels) this.#pixels = affordable;
  }

  /** `full` or less, in its shape. */
  moving(full: Size): Size {
    return withPixels(full, this.#pixels);
  }
}

/** `size` made smaller, in its shape, until it has no more than `pixels`. */
export function withPixels(size: Size, pixels: number): Size {
  const scale = Math.min(1, Math.sqrt(pixels / (size.width * size.height)));
  return {
    width: Math.max(1, Math.round(size.width * scale)),
    height: Math.max(1, Math.round(size.height * scale)),
  };
}
