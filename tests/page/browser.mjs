// What the page's tests stand on: `kinora serve`, a server with faults, Chromium, and claims that are run one by one.
import { spawn } from "node:child_process";
import { existsSync } from "node:fs";
import http from "node:http";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";

export const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
const chromium = ["/usr/bin/chromium", "/usr/bin/chromium-browser"].find(existsSync);

/** Why the page cannot be tested here, or null. */
export function missing() {
  if (!existsSync(path.join(root, "build/page/index.html"))) return "the page is not built: run web/build";
  if (!existsSync(path.join(root, "web/node_modules/playwright-core"))) return "playwright-core is missing: run web/build";
  return chromium ? null : "Chromium is not installed: run scripts/setup";
}

export async function launch() {
  const driver = createRequire(path.join(root, "web/package.json"))("playwright-core");
  // --no-sandbox: continuous integration runs as root.
  return driver.chromium.launch({ executablePath: chromium, args: ["--no-sandbox"] });
}

/** Resolves to {address, stop} of `kinora serve`. */
export async function serve(kinora, folder) {
  const server = spawn(kinora, ["serve", folder, "--port", "0", "--json"], { stdio: ["ignore", "pipe", "inherit"] });
  let said = "";
  for await (const piece of server.stdout) {
    said += piece;
    if (said.includes("}")) break;
  }
  if (!said.includes("}")) throw new Error(`kinora serve ended: ${said}`);
  return { address: JSON.parse(said).address, stop: () => server.kill("SIGINT") };
}

/** A server that keeps what it says only in part. `bytes`: of a clip. */
export async function serveFaults(bytes) {
  const open = { "Access-Control-Allow-Origin": "*" };
  // Of /head.mkv: what comes at once, and how the rest comes.
  const held = { bytes: 0, waiting: [], letGo: () => held.waiting.splice(0).forEach((go) => go()) };
  const answers = {
    "/cut_off.mkv": (response) => {
      response.writeHead(200, { ...open, "Content-Length": bytes.length });
      response.write(bytes.subarray(0, bytes.length / 2), () => response.destroy());
    },
    "/not_shared.mkv": (response) => response.writeHead(200).end(bytes),
    "/head.mkv": (response) => {
      response.writeHead(200, { ...open, "Content-Length": bytes.length });
      response.write(bytes.subarray(0, held.bytes));
      held.waiting.push(() => response.end(bytes.subarray(held.bytes)));
    },
    "/breaks.mkv": (response, range) => {
      const [, first, last] = /^bytes=(\d+)-(\d*)/.exec(range ?? "bytes=0-");
      const end = Math.min(Number(first) + (last ? Infinity : 200000), bytes.length);
      const rest = { "Content-Length": bytes.length - first, "Content-Range": `bytes ${first}-${bytes.length - 1}/${bytes.length}` };
      response.writeHead(range ? 206 : 200, { ...open, "Access-Control-Expose-Headers": "Content-Range", ...rest });
      response.write(bytes.subarray(Number(first), end), () => (end < bytes.length ? response.destroy() : response.end()));
    },
    "/plain.mkv": (response) => response.writeHead(200, { ...open, "Transfer-Encoding": "chunked" }).end(bytes),
    "/slow.mkv": (response) => response.writeHead(200, open).write(bytes.subarray(0, 1000)),
  };
  const server = http.createServer((request, response) => {
    const answer = answers[request.url];
    if (request.method === "OPTIONS") response.writeHead(204, { ...open, "Access-Control-Allow-Headers": "Range" }).end();
    else if (answer) answer(response, request.headers.range);
    else response.writeHead(404, open).end();
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const stop = () => {
    server.close();
    server.closeAllConnections();
  };
  return { address: `http://127.0.0.1:${server.address().port}`, stop, held };
}

/**
 * A server with ranges that gives nothing from byte `from` up to byte `until` before it is let go. `asked`: where the
 * requests began.
 */
export async function serveWithoutMiddle(bytes, from, until) {
  const asked = [];
  const held = [];
  let free = false;
  const open = { "Access-Control-Allow-Origin": "*", "Access-Control-Expose-Headers": "Content-Range" };
  const server = http.createServer((request, response) => {
    if (request.method === "OPTIONS") return response.writeHead(204, { ...open, "Access-Control-Allow-Headers": "Range" }).end();
    const [, first, last] = /^bytes=(\d+)-(\d*)/.exec(request.headers.range ?? "") ?? [];
    const begin = Number(first ?? 0);
    const end = last ? Number(last) + 1 : bytes.length;
    asked.push(begin);
    const range = first === undefined ? {} : { "Content-Range": `bytes ${begin}-${end - 1}/${bytes.length}` };
    response.writeHead(first === undefined ? 200 : 206, { ...open, ...range, "Content-Length": end - begin });
    const given = free || begin >= until ? end : Math.min(Math.max(from, begin), end);
    response.write(bytes.subarray(begin, given));
    if (given === end) response.end();
    else held.push(() => response.end(bytes.subarray(given, end)));
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const letGo = () => {
    free = true;
    for (const go of held.splice(0)) go();
  };
  const stop = () => {
    server.close();
    server.closeAllConnections();
  };
  return { address: `http://127.0.0.1:${server.address().port}`, asked, letGo, stop };
}

/** The folder, also at without_ranges/, and, at page/, the page by nginx; null if there is none. */
export async function serveByNginx(folder) {
  const program = ["/usr/sbin/nginx", "/usr/bin/nginx"].find(existsSync);
  if (!program) return null;
  const own = await mkdtemp(path.join(tmpdir(), "kinora-nginx-"));
  const port = await freePort();
  const temporary = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"].map((name) => `${name}_temp_path ${own}/${name};`);
  const user = process.getuid() === 0 ? "user root;" : ""; // who may read the folder
  const settings = `${user} daemon off; pid ${own}/pid; error_log ${own}/error.log;
    events {}
    http {
      include /etc/nginx/mime.types; access_log off; ${temporary.join(" ")}
      server { listen 127.0.0.1:${port}; root ${path.resolve(folder)}; location /page/ { alias ${root}/build/page/; gzip_static on; }
        location /without_ranges/ { alias ${path.resolve(folder)}/; max_ranges 0; } }
    }`;
  await writeFile(path.join(own, "nginx.conf"), settings);
  const server = spawn(program, ["-e", `${own}/error.log`, "-c", `${own}/nginx.conf`], { stdio: "inherit" });
  const address = `http://127.0.0.1:${port}/`;
  for (;;) {
    if (server.exitCode !== null) throw new Error("nginx ended");
    if (await fetch(address).then(() => true, () => false)) break;
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  const stop = async () => {
    server.kill();
    await rm(own, { recursive: true, force: true });
  };
  return { address, stop };
}

async function freePort() {
  const probe = http.createServer();
  await new Promise((resolve) => probe.listen(0, "127.0.0.1", resolve));
  const { port } = probe.address();
  await new Promise((resolve) => probe.close(resolve));
  return port;
}

const claims = [];
export const claim = (sentence, body) => claims.push([sentence, body]);

/** Runs those that have the words in them, says which hold; how many do not. */
export async function runClaims(world, words = "") {
  let wrong = 0;
  for (const [sentence, body] of claims.filter(([text]) => text.includes(words))) {
    const started = performance.now();
    try {
      await body(world);
      console.log(`holds: ${sentence} (${((performance.now() - started) / 1000).toFixed(1)} s)`);
    } catch (error) {
      ++wrong;
      console.log(`DOES NOT HOLD: ${sentence}\n${error.stack ?? error}`);
    }
  }
  return wrong;
}
