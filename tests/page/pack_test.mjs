// Packs the page's player for npm, installs the package into an empty folder and imports it as a page's own code would.
// usage: node pack_test.mjs
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { mkdtemp, readdir, rm, stat, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { root } from "./browser.mjs";

const npm = (folder, ...words) => execFileSync("npm", words, { cwd: folder, encoding: "utf8" });

function missing() {
  if (!existsSync(path.join(root, "build/page/index.html"))) return "the page is not built: run web/build";
  if (!existsSync(path.join(root, "web/node_modules/typescript"))) return "TypeScript is missing: run web/build";
  try {
    npm(root, "--version");
    return null;
  } catch {
    return "there is no npm";
  }
}

const reason = missing();
if (reason) {
  console.log(`skipped: ${reason}`);
  process.exit(77);
}
const folder = await mkdtemp(path.join(tmpdir(), "kinora-pack-"));
try {
  const said = execFileSync(path.join(root, "web/pack"), ["--built"], { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
  const packed = path.join(root, "build", said.trim().split("\n").at(-1));
  await writeFile(path.join(folder, "package.json"), JSON.stringify({ name: "page-of-somebody", private: true, type: "module" }));
  npm(folder, "install", "--offline", "--no-audit", "--no-fund", "--ignore-scripts", packed);

  const files = await readdir(path.join(folder, "node_modules/kinora-player"));
  for (const name of ["kinora-player.js", "kinora-worker.js", "kinora-player.wasm", "kinora-three.js", "index.html", "types", "LICENSE"]) {
    assert.ok(files.includes(name), `${name} is not among ${files}`);
  }
  const page = path.join(root, "build/page");
  const compressed = (await readdir(page)).filter((name) => name.endsWith(".gz"));
  const sizes = await Promise.all(compressed.map(async (name) => (await stat(path.join(page, name))).size));
  const bytes = sizes.reduce((sum, size) => sum + size, 0);
  assert.ok(compressed.includes("kinora-player.wasm.gz") && bytes <= 1.2e6, `the code is ${bytes} bytes by gzip`);
  // What a browser has and Node.js has not.
  await writeFile(
    path.join(folder, "page.js"),
    `globalThis.HTMLElement = class {};
    const elements = {};
    globalThis.customElements = { define: (name, made) => (elements[name] = made), get: (name) => elements[name] };
    const { KinoraPlayerElement } = await import("kinora-player");
    if (elements["kinora-player"] !== KinoraPlayerElement) throw new Error("no element kinora-player");
    if (typeof KinoraPlayerElement.prototype.play !== "function") throw new Error("the element cannot play");`,
  );
  execFileSync(process.execPath, ["page.js"], { cwd: folder, stdio: "inherit" });
  console.log(`holds: ${path.basename(packed)} installs, imports and brings its files`);
} finally {
  await rm(folder, { recursive: true, force: true });
}
