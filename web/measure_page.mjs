// What a person waits for in Chromium, by this machine's clock: the first picture at 10 Mbit/s and a cold cache, pictures a
// second, the full picture at rest, how long the page's thread is blocked, memory; medians. No other Chromium may run.
// usage: node measure_page.mjs CLIP.mkv [RUNS [LOOPING_SECONDS]]
import { readdir, readFile } from "node:fs/promises";
import http from "node:http";
import path from "node:path";
import { launch, root } from "../tests/page/browser.mjs";

const [clip, runs = 5, looping = 20] = process.argv.slice(2);
const bytesPerSecond = 10e6 / 8;
const looks = 5; // at the memory while it loops
const types = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };

/** Of the browser's process that runs the page and its workers, the largest of its kind: what is its own (as the browser's
 * task manager counts it), and with it the pages of the browser's program, which all its processes share. */
async function megabytes() {
  const sizes = await Promise.all((await readdir("/proc")).filter(Number).map(async (id) => {
    const text = (name) => readFile(`/proc/${id}/${name}`, "utf8").catch(() => "");
    if (!(await text("cmdline")).includes("--type=renderer")) return [0, 0];
    const status = await text("status");
    return ["RssAnon", "VmRSS"].map((name) => Number(new RegExp(`${name}:\\s*(\\d+)`).exec(status)?.[1] ?? 0) / 1024);
  }));
  const [own, resident] = sizes.reduce((largest, size) => (size[1] > largest[1] ? size : largest));
  return { own, resident };
}

/** All answers share the line. */
let free = 0; // milliseconds when the line is
async function send(response, bytes) {
  const piece = 8192;
  free = Math.max(free, performance.now());
  for (let at = 0; at < bytes.length; at += piece) {
    const part = bytes.subarray(at, at + piece);
    free += (1000 * part.length) / bytesPerSecond;
    await new Promise((resolve) => setTimeout(resolve, free - performance.now()));
    response.write(part);
  }
  response.end();
}
const server = http.createServer(async (request, response) => {
  const name = new URL(request.url, "http://host").pathname;
  if (name === "/clip.mkv") {
    const bytes = await readFile(clip);
    const [, first, last] = /^bytes=(\d+)-(\d*)/.exec(request.headers.range ?? "") ?? [];
    if (first === undefined) {
      response.writeHead(200, { "Content-Length": bytes.length });
      return send(response, bytes);
    }
    const part = bytes.subarray(Number(first), last ? Number(last) + 1 : bytes.length);
    const range = `bytes ${first}-${Number(first) + part.length - 1}/${bytes.length}`;
    response.writeHead(206, { "Content-Length": part.length, "Content-Range": range });
    return send(response, part);
  }
  const file = path.join(root, "build/page", path.basename(name));
  response.writeHead(200, { "Content-Type": types[path.extname(file)], "Content-Encoding": "br", "Cache-Control": "max-age=99" });
  return send(response, await readFile(`${file}.br`));
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const address = `http://127.0.0.1:${server.address().port}/index.html?clip=clip.mkv`;

const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];
const measured = {};
const note = (what, value) => (measured[what] ??= []).push(value);
const browser = await launch();
for (let run = 0; run < runs; ++run) {
  const context = await browser.newContext({ viewport: { width: 640, height: 480 } }); // a cold cache
  const page = await context.newPage();
  await page.addInitScript(() => {
    globalThis.blocked = [0];
    new PerformanceObserver((list) => globalThis.blocked.push(...list.getEntries().map((e) => e.duration))).observe({ type: "longtask", buffered: true });
    const tell = HTMLElement.prototype.dispatchEvent;
    HTMLElement.prototype.dispatchEvent = function (event) {
      (globalThis.times ??= {})[event.type] ??= performance.now();
      return tell.call(this, event);
    };
  });
  await page.goto(address);
  const wait = (text) => page.waitForFunction(text, null, { polling: 50, timeout: 60000 });
  await wait(() => document.querySelector("kinora-player").readyState === 4);
  const times = await page.evaluate(() => globalThis.times);
  const fetched = await page.evaluate(() => performance.getEntriesByType("resource").map(({ name, startTime, responseEnd }) => ({ name, startTime, responseEnd })));
  for (const [what, end] of [["the page's script", "kinora-page.js"], ["the player's code", "kinora-player.wasm"], ["the clip's first bytes", "clip.mkv"]]) {
    const { startTime, responseEnd } = fetched.find(({ name }) => name.endsWith(end));
    note(`${what}: asked for, ms`, startTime);
    note(`${what}: there, ms`, responseEnd);
  }
  note("first bytes opened, ms", times.loadedmetadata);
  note("first picture, ms", times.loadeddata);
  note("all of it, ms", times.canplaythrough);
  await page.waitForTimeout(2000); // the second worker joins
  await page.evaluate(() => (globalThis.blocked = [0]));
  const pictures = await page.evaluate(async () => {
    const player = document.querySelector("kinora-player");
    const canvas = player.shadowRoot.querySelector("canvas");
    const put = CanvasRenderingContext2D.prototype.putImageData;
    let count = 0;
    CanvasRenderingContext2D.prototype.putImageData = function (...words) {
      ++count;
      return put.apply(this, words);
    };
    await player.play();
    await new Promise((resolve) => setTimeout(resolve, 5000));
    player.pause();
    const paused = performance.now();
    while (!player.stage.settled) await new Promise((resolve) => setTimeout(resolve, 5));
    return { rate: count / 5, rest: performance.now() - paused, blocked: Math.max(...globalThis.blocked), size: canvas.width };
  });
  note("pictures a second in motion", pictures.rate);
  note("full picture after it rests, ms", pictures.rest);
  note("longest task of the page's thread while it plays, ms (0: none above 50)", pictures.blocked);
  if (run + 1 < runs) await context.close();
  else {
    const session = await context.newCDPSession(page);
    const workers = [];
    session.on("Target.attachedToTarget", ({ sessionId }) => workers.push(sessionId));
    await session.send("Target.setAutoAttach", { autoAttach: true, waitForDebuggerOnStart: false, flatten: false });
    /** Of the page's heap, once the browser has collected what nobody needs, in workers too: it does so rarely by itself. */
    const memory = async () => {
      const message = JSON.stringify({ id: 1, method: "HeapProfiler.collectGarbage" });
      for (const sessionId of workers) await session.send("Target.sendMessageToTarget", { sessionId, message });
      await session.send("HeapProfiler.collectGarbage");
      await page.waitForTimeout(1000);
      const { usedSize } = await session.send("Runtime.getHeapUsage");
      return usedSize / 1e6;
    };
    await page.evaluate(() => {
      const player = document.querySelector("kinora-player");
      player.loop = true;
      player.playbackRate = 16;
      void player.play();
    });
    for (let look = 0; look <= looks; ++look) {
      const when = look ? ` after ${(looping * look) / looks} s of looping at speed 16` : "";
      if (look) await page.waitForTimeout((1000 * looping) / looks);
      note(`page's heap${when}, MB`, await memory());
      const { own, resident } = await megabytes();
      note(`renderer process${when}, its own memory, MB`, own);
      note(`renderer process${when}, with the browser's program, MB`, resident);
    }
  }
}
for (const [what, values] of Object.entries(measured)) console.log(`${what}: ${median(values).toFixed(1)} (of ${values.length})`);
await browser.close();
server.close();
server.closeAllConnections();
