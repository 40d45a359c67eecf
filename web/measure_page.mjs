// What a person waits for in Chromium, by this machine's clock: the first picture at 10 Mbit/s and a cold cache, pictures a
// second, the full picture at rest, how long the page's thread is blocked, memory; medians.
// usage: node measure_page.mjs CLIP.mkv [RUNS [LOOPING_SECONDS]]
import { readFile } from "node:fs/promises";
import http from "node:http";
import path from "node:path";
import { launch, root } from "../tests/page/browser.mjs";

const [clip, runs = 5, looping = 20] = process.argv.slice(2);
const bytesPerSecond = 10e6 / 8;
const types = { ".html": "text/html", ".js": "text/javascript", ".wasm": "application/wasm" };

/** All answers share the line. */
let free = 0; // milliseconds when the line is
async function send(response, bytes) {
  const piece = 8192;
  for (let at = 0; at < bytes.length; at += piece) {
    const part = bytes.subarray(at, at + piece);
    free = Math.max(free, performance.now()) + (1000 * part.length) / bytesPerSecond;
    await new Promise((resolve) => setTimeout(resolve, free - performance.now()));
    response.write(part);
  }
  response.end();
}
const server = http.createServer(async (request, response) => {
  const name = new URL(request.url, "http://host").pathname;
  if (name === "/clip.mkv") {
    const bytes = await readFile(clip);
    response.writeHead(200, { "Content-Length": bytes.length });
    return send(response, bytes);
  }
  const file = path.join(root, "build/page", path.basename(name));
  response.writeHead(200, { "Content-Type": types[path.extname(file)], "Content-Encoding": "gzip", "Cache-Control": "max-age=99" });
  return send(response, await readFile(`${file}.gz`));
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
    const memory = async () => {
      await session.send("HeapProfiler.collectGarbage");
      const { jsHeapUsedSize } = await session.send("Runtime.getHeapUsage").then((r) => ({ jsHeapUsedSize: r.usedSize }));
      return jsHeapUsedSize / 1e6;
    };
    await page.evaluate(() => {
      const player = document.querySelector("kinora-player");
      player.loop = true;
      player.playbackRate = 16;
      void player.play();
    });
    note("page's heap, MB", await memory());
    await page.waitForTimeout(1000 * looping);
    note(`page's heap after ${looping} s of looping at speed 16, MB`, await memory());
  }
}
for (const [what, values] of Object.entries(measured)) console.log(`${what}: ${median(values).toFixed(1)} (of ${values.length})`);
await browser.close();
server.close();
server.closeAllConnections();
