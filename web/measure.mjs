// Processor time of opening and drawing a clip by the module that web/build made, in Node.js: of its first BYTES, and
// all of it. usage: node measure.mjs CLIP.mkv [BYTES...]
import { readFileSync } from "node:fs";
import { readFile } from "node:fs/promises";

const built = new URL("../build/wasm/bin/", import.meta.url);
globalThis.self ??= { location: { href: built.href } }; // the module is for workers
const { default: createModule } = await import(new URL("kinora_module.mjs", built));

let before = process.cpuUsage();
function lap(what) {
  const { user, system } = process.cpuUsage(before);
  console.log(`${what}: ${Math.round((user + system) / 1000)} ms`);
  before = process.cpuUsage();
}

const clip = await readFile(process.argv[2]);
const m = await createModule({
  instantiateWasm(imports, received) {
    const code = new WebAssembly.Module(readFileSync(new URL("kinora_module.wasm", built)));
    const instance = new WebAssembly.Instance(code, imports);
    received(instance);
    return instance.exports;
  },
});
lap("compiling the module");
const [bytes, name, out] = [m._malloc(clip.length), m._malloc(1), m._malloc(8)];
m.HEAPU8.set(clip, bytes);
m.HEAPU8[name] = 0;
function open(size, firstLook = 0) {
  const status = m._module_open_arrived(bytes, size, name, Number(size === clip.length), firstLook, out, out + 4);
  const sentence = m.UTF8ToString(m._module_arrived_sentence());
  if (status !== 0) throw new Error(sentence);
  return [m.HEAPU32[out >> 2], sentence];
}
for (const size of process.argv.slice(3).map(Number)) {
  const [part, missing] = open(size, 1);
  lap(`a first look at the first ${size} bytes (${part ? missing : "nothing can be shown"})`);
  if (part) m._kinora_player_close(part);
}
const [player] = open(clip.length);
lap("opening the clip");

const [camera, visible] = [m._malloc(8 * 22), m._malloc(64)];
m.HEAPU8.fill(1, visible, visible + 64);
for (const [width, preview] of [[320, 1], [640, 1], [640, 0]]) {
  for (let i = 0; i < 4; ++i) {
    m._module_capture_camera(player, i / 30, camera);
    const c = m.HEAPF64.subarray(camera >> 3, (camera >> 3) + 22);
    const scale = width / c[0];
    const height = Math.round(c[1] * scale);
    c.set([width, height, c[2] * scale, c[3] * scale, (c[4] + 0.5) * scale - 0.5, (c[5] + 0.5) * scale - 0.5]);
    const color = m._malloc(4 * width * height);
    m._module_draw(player, i / 30, camera, visible, 0, preview, color, 0);
    m._free(color);
    lap(`${preview ? "a preview" : "a picture"} of ${width}x${height}`);
  }
}
console.log(`memory: ${Math.round(m.HEAPU8.length / 1e6)} MB`);
