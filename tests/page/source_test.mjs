// How the page's player fetches a clip, and when its clock runs, in Node.js: no browser, no WebAssembly.
// FOLDER holds carry_box.mkv. usage: node source_test.mjs KINORA FOLDER
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import http from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import path from "node:path";
import { claim, root, runClaims, serveWithoutMiddle } from "./browser.mjs";
import { longClip } from "./long_clip.mjs";

if (!existsSync(path.join(root, "web/node_modules/esbuild"))) {
  console.log("skipped: esbuild is missing: run web/build");
  process.exit(77);
}
const [kinora, folder] = process.argv.slice(2);

/** What files of web/src export. */
async function sources(...names) {
  const { build } = createRequire(path.join(root, "web/package.json"))("esbuild");
  const work = await mkdtemp(path.join(tmpdir(), "kinora-source-"));
  const contents = names.map((name) => `export * from "./${name}.js";`).join("\n");
  const made = await build({ stdin: { contents, resolveDir: path.join(root, "web/src") }, bundle: true, format: "esm", write: false });
  const file = path.join(work, "sources.mjs");
  await writeFile(file, made.outputFiles[0].contents);
  const module = await import(file);
  await rm(work, { recursive: true });
  return module;
}

const wholeOf = async (source) => {
  await source.beyond(Infinity);
  assert.equal(source.fault, null);
  return Buffer.from(await source.blob().arrayBuffer());
};
const fetched = (ClipSource, address, from = address) => {
  globalThis.location = { origin: from }; // of the page
  const clip = `${address}/clip.mkv`;
  return ClipSource.fetched(clip, new AbortController().signal, Promise.resolve(), () => undefined);
};

for (const where of ["its own server", "another server"]) {
  claim(`what is sought comes from ${where} before what lies between, and the whole is the file`, async ({ ClipSource, bytes, clusters }) => {
    const [second, last] = [clusters[1], clusters.at(-1)];
    const server = await serveWithoutMiddle(bytes, second.at + 1000, last.at);
    const source = fetched(ClipSource, server.address, where === "another server" ? "http://elsewhere" : server.address);
    await source.beyond(second.at + 999);
    const before = source.bytes;
    await source.seek(last.seconds + 1);
    await source.beyond(Infinity); // what was sought is worth a look
    assert.equal(source.all, false);
    const pieces = Buffer.from(await source.blob().arrayBuffer());
    assert.ok(pieces.equals(Buffer.concat([bytes.subarray(0, before), bytes.subarray(last.at)])));
    assert.equal(server.asked.at(-1), last.at, `the requests began at ${server.asked}`);
    await source.seek(last.seconds + 2); // is there
    server.letGo();
    assert.ok((await wholeOf(source)).equals(bytes));
    assert.deepEqual(server.asked.slice(-2), [last.at, before]);
    server.stop();
  });
}

claim("a server without ranges gives the file in its order", async ({ ClipSource, bytes, clusters }) => {
  const asked = [];
  let letGo;
  const server = http.createServer((request, response) => {
    asked.push(request.headers.range);
    response.writeHead(200, { "Content-Length": bytes.length }).write(bytes.subarray(0, 200000));
    letGo = () => response.end(bytes.subarray(200000));
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const source = fetched(ClipSource, `http://127.0.0.1:${server.address().port}`);
  await source.beyond(199999);
  await source.seek(clusters.at(-1).seconds);
  letGo();
  assert.ok((await wholeOf(source)).equals(bytes));
  assert.equal(asked.length, 1);
  server.closeAllConnections();
  server.close();
});

claim("an index that is not in the head is found at the end of the file", async ({ ClipSource, bytes, clusters }) => {
  const silent = Buffer.from(bytes);
  const seek = silent.indexOf("53ab841c53bb6b", 0, "hex");
  silent.fill(0xff, seek + 3, seek + 7); // the head names no index
  const server = await serveWithoutMiddle(silent, clusters[1].at, clusters[1].at + 1);
  const source = fetched(ClipSource, server.address);
  await source.beyond(clusters[1].at - 1);
  await source.seek(clusters.at(-1).seconds + 1);
  await source.beyond(Infinity);
  assert.equal(server.asked.at(-1), clusters.at(-1).at, `the requests began at ${server.asked}`);
  source.blob(); // is looked at
  server.letGo();
  assert.ok((await wholeOf(source)).equals(silent));
  server.stop();
});

claim("so much is held and no more: what came before can be played, and a sentence says so", async ({ ClipSource }) => {
  const most = 256 << 20;
  const chunk = Buffer.alloc(1 << 20);
  let asked = 0;
  const server = http.createServer((request, response) => {
    asked += 1;
    const { from, until } = /bytes=(?<from>\d+)-(?<until>\d*)/.exec(request.headers.range).groups;
    const end = until === "" ? 2 * most : Number(until) + 1;
    response.writeHead(206, { "Content-Range": `bytes ${from}-${end - 1}/${2 * most}` });
    let at = Number(from);
    const go = () => {
      while (at < end) {
        const piece = chunk.subarray(0, Math.min(chunk.length, end - at));
        at += piece.length;
        if (!response.write(piece)) return void response.once("drain", go);
      }
      response.end();
    };
    go();
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const source = fetched(ClipSource, `http://127.0.0.1:${server.address().port}`);
  await source.beyond(2 * most);
  assert.match(source.fault.message, /is larger than 256 MB; cut it with kinora cut$/);
  assert.equal(source.all, false);
  assert.ok(source.bytes <= most && source.bytes > most - (2 << 20), `${source.bytes} bytes`);
  assert.equal(source.blob().size, source.bytes);
  assert.equal(asked, 2, "the head, and the rest");
  server.closeAllConnections();
  server.close();
});

claim("the clock does not run into what has not come", ({ PlaybackClock }) => {
  let now = 0;
  const clock = new PlaybackClock(0, 0, () => now);
  clock.setEnd(12, [{ from: 0, to: 5 }, { from: 10, to: 12 }]);
  clock.play();
  now = 3;
  assert.deepEqual([clock.time, clock.starved], [3, false]);
  now = 9;
  assert.deepEqual([clock.time, clock.starved], [5, true]);
  clock.seek(11);
  now = 9.5;
  assert.deepEqual([clock.time, clock.starved], [11.5, false]);
  now = 20;
  assert.deepEqual([clock.time, clock.starved, clock.ended], [12, true, false]);
  clock.seek(7);
  now = 30;
  assert.deepEqual([clock.time, clock.starved], [7, true]);
  clock.setEnd(12, [{ from: 0, to: 8 }, { from: 10, to: 12 }]);
  now = 30.5;
  assert.deepEqual([clock.time, clock.starved], [7.5, false]);
  clock.setEnd(12, null);
  now = 32;
  assert.equal(clock.time, 9);
  now = 60;
  assert.deepEqual([clock.time, clock.ended], [12, true]);
});

const wrong = await runClaims({ ...(await sources("source", "clock")), ...(await longClip(kinora, folder)) });
process.exit(wrong === 0 ? 0 : 1);
