// The part of <video>'s interface that is plain attributes: each property is its attribute.

export class MediaAttributes extends HTMLElement {
  get src(): string {
    return this.getAttribute("src") ?? "";
  }
  set src(address: string) {
    this.setAttribute("src", address);
  }
  get poster(): string {
    return this.getAttribute("poster") ?? "";
  }
  set poster(address: string) {
    this.setAttribute("poster", address);
  }
  get autoplay(): boolean {
    return this.hasAttribute("autoplay");
  }
  set autoplay(on: boolean) {
    this.toggleAttribute("autoplay", on);
  }
  get controls(): boolean {
    return this.hasAttribute("controls");
  }
  set controls(on: boolean) {
    this.toggleAttribute("controls", on);
  }
  get loop(): boolean {
    return this.hasAttribute("loop");
  }
  set loop(on: boolean) {
    this.toggleAttribute("loop", on);
  }
  get muted(): boolean {
    return this.hasAttribute("muted");
  }
  set muted(on: boolean) {
    this.toggleAttribute("muted", on);
  }
}
