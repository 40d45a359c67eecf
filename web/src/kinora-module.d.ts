// What web/module gives. Addresses are numbers of bytes in the module's memory.
declare module "kinora-module" {
  export interface KinoraModule {
    HEAPU8: Uint8Array<ArrayBuffer>;
    HEAPU32: Uint32Array<ArrayBuffer>;
    HEAPF32: Float32Array<ArrayBuffer>;
    HEAPF64: Float64Array<ArrayBuffer>;
    UTF8ToString(address: number): string;
    stringToUTF8(text: string, address: number, maxBytes: number): void;
    GL: {
      registerContext(context: WebGL2RenderingContext, attributes: { majorVersion: number; minorVersion: number }): number;
      makeContextCurrent(handle: number): boolean;
    };
    _module_gl_open(): number;
    _module_gl_close(renderer: number): void;
    _module_gl_error(): number;
    _module_gl_draw(
      renderer: number,
      player: number,
      seconds: number,
      camera: number,
      visible: number,
      color: number,
    ): number;
    _malloc(bytes: number): number;
    _free(address: number): void;
    _module_open_arrived(
      bytes: number,
      size: number,
      name: number,
      all: number,
      firstLook: number,
      player: number,
      finished: number,
    ): number;
    _module_arrived_sentence(): number;
    _module_arrived_frames(seconds: number, there: number): number;
    _module_sound(player: number, codec: number, setup: number, setupBytes: number, numbers: number): number;
    _module_sound_packet(player: number, packet: number, data: number, seconds: number): number;
    _kinora_player_close(player: number): void;
    _kinora_player_error(): number;
    _kinora_player_subject(player: number, seconds: number, out: number): number;
    _module_info(player: number, out: number): number;
    _module_layer(player: number, layer: number, name: number, motion: number): number;
    _module_frame_times(player: number, frames: number, out: number): number;
    _module_capture_camera(player: number, seconds: number, out: number): number;
    _module_draw(
      player: number,
      seconds: number,
      camera: number,
      visible: number,
      view: number,
      preview: number,
      color: number,
      depth: number,
    ): number;
  }
  type Received = (instance: WebAssembly.Instance) => void;
  export default function createModule(options: {
    instantiateWasm(imports: WebAssembly.Imports, received: Received): object;
  }): Promise<KinoraModule>;
}
