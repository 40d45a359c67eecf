// Drawing by WebGL 2 in a worker: the player's shaders, where a GPU draws them.
import type { KinoraModule } from "kinora-module";

const software = /llvmpipe|softpipe|swiftshader|software/i;

export class GpuDrawing {
  #renderer = 0; // 0: the context is lost, or was never found fit

  private constructor(
    private readonly module: KinoraModule,
    canvas: OffscreenCanvas,
    private readonly webgl: WebGL2RenderingContext,
  ) {
    this.#open();
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault(); // so that it is restored
      this.#close();
    });
    canvas.addEventListener("webglcontextrestored", () => this.#open());
  }

  /** null: there is no WebGL 2, or it is a program on the CPU, where our own is faster; unless it is wanted `anyway`. */
  static open(module: KinoraModule, anyway: boolean): GpuDrawing | null {
    if (typeof OffscreenCanvas === "undefined") return null;
    const canvas = new OffscreenCanvas(1, 1);
    const webgl = canvas.getContext("webgl2", { failIfMajorPerformanceCaveat: !anyway, antialias: false });
    if (!webgl) return null;
    const known = webgl.getExtension("WEBGL_debug_renderer_info");
    const name = String(webgl.getParameter(known ? known.UNMASKED_RENDERER_WEBGL : webgl.RENDERER));
    if (!anyway && software.test(name)) return null;
    return new GpuDrawing(module, canvas, webgl);
  }

  /** False: the CPU has to. */
  draw(player: number, time: number, camera: number, visible: number, color: number): boolean {
    if (this.#renderer === 0) return false;
    if (this.module._module_gl_draw(this.#renderer, player, time, camera, visible, color) === 0) return true;
    console.warn(`Kinora draws without the GPU: ${this.module.UTF8ToString(this.module._module_gl_error())}`);
    this.#close();
    return false;
  }

  #close(): void {
    if (this.#renderer !== 0) this.module._module_gl_close(this.#renderer);
    this.#renderer = 0;
  }

  #open(): void {
    // This asks for its extensions too, which a context that was restored has no more.
    this.module.GL.makeContextCurrent(this.module.GL.registerContext(this.webgl, { majorVersion: 2, minorVersion: 0 }));
    this.#renderer = this.module._module_gl_open();
    if (this.#renderer === 0) {
      console.warn(`Kinora draws without the GPU: ${this.module.UTF8ToString(this.module._module_gl_error())}`);
    }
  }
}
