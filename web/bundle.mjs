// Bundles src/ and what Emscripten made of web/module into one folder. usage: node bundle.mjs MODULE_FOLDER OUT
import { build } from "esbuild";
import { copyFile, mkdir, rm, writeFile, readdir, readFile } from "node:fs/promises";
import { brotliCompressSync, gzipSync } from "node:zlib";
import path from "node:path";
import { fileURLToPath } from "node:url";

const web = path.dirname(fileURLToPath(import.meta.url));
const [moduleFolder, out] = process.argv.slice(2).map((name) => path.resolve(name));
if (!moduleFolder || !out) throw new Error("usage: node bundle.mjs MODULE_FOLDER OUT");

await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
await build({
  entryPoints: {
    "kinora-player": path.join(web, "src/index.ts"),
    "kinora-worker": path.join(web, "src/worker.ts"),
    "kinora-page": path.join(web, "src/page.ts"),
    "kinora-three": path.join(web, "src/three.ts"),
  },
  outdir: out,
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "none",
  logLevel: "warning",
  alias: { "kinora-module": path.join(moduleFolder, "kinora_module.mjs") },
  external: ["three"],
});
await copyFile(path.join(moduleFolder, "kinora_module.wasm"), path.join(out, "kinora-player.wasm"));
await copyFile(path.join(web, "page/index.html"), path.join(out, "index.html"));

// For servers that give what was compressed before.
const packers = { gz: (bytes) => gzipSync(bytes, { level: 9 }), br: (bytes) => brotliCompressSync(bytes) };
const packed = { gz: 0, br: 0 };
let plain = 0;
for (const name of await readdir(out)) {
  const bytes = await readFile(path.join(out, name));
  plain += bytes.length;
  for (const [ending, pack] of Object.entries(packers)) {
    const small = pack(bytes);
    await writeFile(path.join(out, `${name}.${ending}`), small);
    packed[ending] += small.length;
  }
}
const kilobytes = (bytes) => Math.ceil(bytes / 1e3);
console.log(`page: ${out}: ${kilobytes(plain)} kB, by gzip ${kilobytes(packed.gz)} kB, by Brotli ${kilobytes(packed.br)} kB`);
