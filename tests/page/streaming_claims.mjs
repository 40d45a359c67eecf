// A clip that is seen while it comes.
import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { claim, serveWithoutMiddle } from "./browser.mjs";
import { longClip } from "./long_clip.mjs";
import { closed, keep, opened, psnr, rests, shown } from "./pages.mjs";

const near = (a, b) => Math.abs(a - b) < 1e-3;

/** A page without a clip: what comes is watched from the first byte on. */
async function empty({ browser, served }) {
  const page = await opened({ browser, served }, "nowhere.mkv");
  await page.getByRole("alert").waitFor();
  return page;
}

claim("a picture is shown from the head of the file, and becomes sharper as more comes", async (world) => {
  const page = await empty(world);
  world.faults.held.bytes = 130000; // the coarse levels of all three layers
  await page.player("player.loop = false; player.src = given", `${world.faults.address}/head.mkv`);
  await page.waitForFunction(() => {
    const player = document.querySelector("kinora-player");
    return player.readyState === 3 && player.layers.length === 3;
  });
  await page.player("player.pause()");
  await keep(page, "coarse");
  assert.equal(await page.getByRole("alert").count(), 0);
  await page.screenshot({ path: path.join(world.seen, "head.png") });
  // What has not come yet is waited for.
  await page.player(`globalThis.waits = new Promise((resolve) => player.addEventListener("waiting", resolve, { once: true }));
    globalThis.sought = new Promise((resolve) => player.addEventListener("seeked", resolve, { once: true }));
    player.currentTime = 0.2; return globalThis.waits.then(() => undefined)`);
  assert.equal(await page.player("return player.seeking"), true);
  world.faults.held.letGo();
  await shown(page);
  await page.evaluate(() => globalThis.sought.then(() => undefined));
  assert.ok(Math.abs((await page.player("return player.currentTime")) - 0.2) < 1e-6);
  await page.player("player.currentTime = 0");
  await rests(page);
  await keep(page, "whole");
  await page.screenshot({ path: path.join(world.seen, "whole.png") });
  assert.ok((await psnr(page, "coarse", "whole")) < 40, "the coarse picture is no coarse one");
  await closed(page);
});

claim("what is sought comes before what lies between, and nothing plays into what has not come", async (world) => {
  const { bytes, clusters } = await longClip(world.kinora, world.folder);
  assert.ok(clusters.length >= 3, `${clusters.length} clusters`);
  const [second, last] = [clusters[1], clusters.at(-1)];
  const server = await serveWithoutMiddle(bytes, second.at + 1000, last.at);
  const page = await empty(world);
  await page.player("player.loop = false; player.autoplay = false; player.src = given", `${server.address}/long.mkv`);
  const come = () => page.player("return player.stage?.info.come ?? []");
  await page.waitForFunction((seconds) => {
    const player = document.querySelector("kinora-player");
    return player.readyState === 3 && player.stage.info.come[0].to > seconds;
  }, second.seconds - 0.1);
  const [front] = await come();
  assert.ok(front.to < last.seconds - 1, JSON.stringify(front));
  // It waits where the gap begins.
  await page.player(`globalThis.waits = new Promise((resolve) => player.addEventListener("waiting", resolve, { once: true }));
    player.currentTime = given; void player.play(); return globalThis.waits.then(() => undefined)`, front.to - 0.2);
  assert.ok(near(await page.player("return player.currentTime"), (await come())[0].to));
  assert.equal(await page.player("return player.paused"), false);
  // What lies behind the gap is there first.
  const sought = last.seconds + 1;
  await page.player(`player.pause();
    const seeked = new Promise((resolve) => player.addEventListener("seeked", resolve, { once: true }));
    player.currentTime = given; return seeked.then(() => undefined)`, sought);
  assert.ok(server.asked.includes(last.at), `the requests began at ${server.asked}`);
  assert.equal(await page.player("return player.readyState"), 3);
  assert.equal((await come()).length, 2);
  await page.screenshot({ path: path.join(world.seen, "sought.png") });
  const draw = () => page.player(`const request = { ...player.stage.wanted, camera: { pose: null, width: 80, height: 60 }, preview: true, withDepth: false };
    return player.stage.draw(request).then(({ color }) => [...color])`);
  const early = await draw();
  await page.player("return player.play()");
  await page.waitForFunction((time) => document.querySelector("kinora-player").currentTime > time, sought + 0.2);
  await page.player("player.pause(); player.currentTime = given", sought);
  server.letGo();
  await shown(page);
  assert.equal((await come()).length, 1);
  assert.deepEqual(await draw(), early, "the picture is another once all has come");
  await closed(page);
  server.stop();
});

claim("a connection that breaks again and again is taken up where it broke", async (world) => {
  const page = await empty(world);
  await page.player("player.src = given", `${world.faults.address}/breaks.mkv`);
  await shown(page);
  assert.equal(await page.player("return player.error"), null);
  await closed(page);
});

claim("what is cut or damaged is shown as far as it goes, with a message beside it", async (world) => {
  const clip = await readFile(path.join(world.folder, "carry_box.mkv"));
  const middle = Math.floor(0.6 * clip.length);
  clip.fill(0x55, middle, middle + 1000);
  await writeFile(path.join(world.folder, "damaged.mkv"), clip);
  for (const name of ["cut.mkv", "damaged.mkv"]) {
    const page = await opened(world, name);
    await shown(page);
    await page.getByRole("alert").waitFor();
    assert.match(await page.getByRole("alert").textContent(), /is damaged; missing: /);
    assert.equal(await page.player("return player.error.code"), 3);
    await page.screenshot({ path: path.join(world.seen, `${name}.png`) });
    await closed(page);
  }
});

claim("a file of a newer version is refused with what helps", async (world) => {
  const clip = await readFile(path.join(world.folder, "carry_box.mkv"));
  const tag = clip.indexOf("KINORA_VERSION");
  const value = clip.indexOf("1", tag + "KINORA_VERSION".length, "latin1");
  clip[value] = "9".charCodeAt(0);
  await writeFile(path.join(world.folder, "newer.mkv"), clip);
  const page = await opened(world, "newer.mkv");
  await page.getByRole("alert").waitFor();
  assert.match(await page.getByRole("alert").textContent(), /use a newer Kinora/);
  assert.equal(await page.player("return player.error.code"), 4);
  await closed(page);
});

claim("nginx serves the page and its clips, with ranges and without", async (world) => {
  if (!world.nginx) return console.log("  not tested: there is no nginx; run scripts/setup");
  const page = await world.browser.newPage({ viewport: { width: 640, height: 480 } });
  page.setDefaultTimeout(90000);
  for (const folder of ["..", "../without_ranges"]) {
    const asked = [];
    page.on("response", (answer) => new URL(answer.url()).pathname.endsWith(".mkv") && asked.push(answer.status()));
    await page.goto(`${world.nginx.address}page/index.html?clip=${folder}/carry_box.mkv`);
    await shown(page);
    assert.deepEqual(asked, folder === ".." ? [206, 206] : [200]); // the head and the rest, or all at once
    page.removeAllListeners("response");
  }
  await page.close();
});

claim("a tab that was hidden plays on when it is seen again", async (world) => {
  const page = await opened(world);
  await shown(page);
  const session = await page.context().newCDPSession(page);
  await session.send("Page.setWebLifecycleState", { state: "frozen" });
  await session.send("Page.setWebLifecycleState", { state: "active" });
  await page.player(`return new Promise((resolve) => player.addEventListener("timeupdate", () => resolve(), { once: true }))`);
  await closed(page);
});

claim("an answer without ranges, or with a size that is not said, plays as well", async (world) => {
  const page = await empty(world);
  await page.player("player.src = given", `${world.faults.address}/plain.mkv`);
  await shown(page);
  await closed(page);
});
