// What people do to a clip: keys, menu, full screen, a file that is dropped; and what they see before the first picture.
import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { claim } from "./browser.mjs";
import { closed, keep, opened, psnr, rests, shown } from "./pages.mjs";

const near = (a, b) => Math.abs(a - b) < 1e-3;

claim("keys play, step, seek, turn, come nearer, repeat and mute", async (world) => {
  const page = await opened(world, "carry_box.mkv", {}, "#t=0.1");
  await shown(page);
  const state = () => page.player("const { paused, currentTime, loop, muted, camera } = player; return { paused, currentTime, loop, muted, camera }");
  const press = async (key) => {
    await page.keyboard.press(key);
    return state();
  };
  await page.getByRole("application", { name: "Volumetric video" }).focus();
  assert.ok(near((await press(".")).currentTime, 0.1 + 1.01 / 30));
  assert.ok(near((await press(",")).currentTime, 0.1 + 0.02 / 30));
  assert.equal((await press("ArrowRight")).currentTime, await page.player("return player.duration"));
  assert.equal((await press("ArrowLeft")).currentTime, 0);
  assert.equal((await press("l")).loop, false);
  assert.equal((await press("l")).loop, true);
  assert.equal((await press("m")).muted, true);
  assert.equal((await press("Space")).paused, false);
  assert.equal((await press("k")).paused, true);
  const turned = (await press("Shift+ArrowLeft")).camera;
  assert.ok(Math.abs(turned.position[0]) > 0.05, JSON.stringify(turned));
  const far = (view) => Math.hypot(...view.position.map((x, i) => x - view.target[i]));
  assert.ok(near(far((await press("+")).camera), 0.9 * far(turned)));
  assert.equal((await press("0")).camera, null);
  await closed(page);
});

claim("the menu hides layers, shows depth, changes the speed and copies a link that leads here; f fills the screen", async (world) => {
  const page = await opened(world, "carry_box.mkv", {}, "#t=0.2");
  await shown(page);
  await rests(page);
  await keep(page, "all");
  await page.getByRole("button", { name: "Settings" }).click();
  await page.getByRole("checkbox", { name: "background" }).uncheck();
  await rests(page);
  await keep(page, "two");
  assert.ok((await psnr(page, "all", "two")) < 20, "the background is still there");
  await page.getByRole("checkbox", { name: "background" }).check();
  await page.getByRole("radio", { name: "Depth" }).check();
  await rests(page);
  await keep(page, "depth");
  assert.ok((await psnr(page, "all", "depth")) < 20, "depth looks like colour");
  await page.screenshot({ path: path.join(world.seen, "depth.png") });
  await page.getByRole("radio", { name: "Colour" }).check();
  await page.getByRole("combobox", { name: "Speed" }).selectOption("0.5");
  assert.equal(await page.player("return player.playbackRate"), 0.5);
  await page.player("player.camera = { position: [0.4, -0.2, 0.1], target: [0.1, 0, 2], up: [0, -1, 0] }");
  await page.getByRole("button", { name: "Copy a link to this view" }).click();
  assert.equal(new URL(page.url()).hash, "#t=0.2&cam=0.4,-0.2,0.1,0.1,0,2,0,-1,0");
  await page.keyboard.press("Escape");
  assert.equal(await page.getByRole("checkbox", { name: "person" }).count(), 0, "Escape did not close the menu");
  await page.getByRole("button", { name: "Full screen" }).click();
  await page.waitForFunction(() => document.fullscreenElement?.localName === "kinora-player");
  await rests(page);
  await page.screenshot({ path: path.join(world.seen, "full_screen.png") });
  await page.getByRole("application", { name: "Volumetric video" }).focus();
  await page.keyboard.press("f");
  await page.waitForFunction(() => document.fullscreenElement === null);
  await closed(page);
});

claim("a file that is chosen plays, and one that is dropped onto the player", async (world) => {
  const page = await opened(world, "nowhere.mkv");
  await page.getByRole("alert").waitFor();
  await page.locator("kinora-player input[type=file]").setInputFiles(path.join(world.folder, "carry_box.mkv"));
  await shown(page);
  await page.player("player.src = 'none.mkv'");
  await page.getByRole("alert").waitFor();
  const dropped = await page.evaluateHandle(async (address) => {
    const data = new DataTransfer();
    data.items.add(new File([await (await fetch(address)).blob()], "dropped.mkv"));
    return data;
  }, `${world.served.address}carry_box.mkv`);
  const player = page.locator("kinora-player");
  await player.dispatchEvent("dragover", { dataTransfer: dropped });
  await page.screenshot({ path: path.join(world.seen, "dropping.png") });
  await player.dispatchEvent("drop", { dataTransfer: dropped });
  await shown(page);
  assert.equal(await page.getByRole("alert").count(), 0);
  await closed(page);
});

claim("a poster is seen until the first picture, and a message says what is waited for", async (world) => {
  const page = await opened(world, "nowhere.mkv");
  await page.getByRole("alert").waitFor();
  world.faults.held.bytes = 1000;
  await page.player("player.poster = given[0]; player.src = given[1]", [
    `${world.served.address}native/000006.png`,
    `${world.faults.address}/head.mkv`,
  ]);
  const poster = page.locator("kinora-player img");
  await poster.waitFor();
  await page.getByRole("status").getByText(/Loading: 0.0 of \d\.\d MB/).waitFor();
  await poster.evaluate((image) => image.decode());
  await page.screenshot({ path: path.join(world.seen, "poster.png") });
  world.faults.held.letGo();
  await shown(page);
  assert.equal(await poster.isVisible(), false);
  await page.player("player.pause()");
  await page.getByRole("status").waitFor({ state: "hidden" });
  await closed(page);
});

claim("who wants less motion gets none unasked", async (world) => {
  const page = await opened(world, "carry_box.mkv", { reducedMotion: "reduce" });
  await shown(page);
  assert.equal(await page.player("return player.autoplay && player.paused"), true);
  await page.player("return player.play()");
  assert.equal(await page.player("return player.paused"), false);
  await closed(page);
});

claim("a file that is still being written is followed", async (world) => {
  const clip = await readFile(path.join(world.folder, "carry_box.mkv"));
  const growing = Buffer.from(clip);
  for (const id of ["18538067", "1f43b675"]) { // segment and cluster: of a size that their writer does not know yet
    const size = growing.indexOf(id, 0, "hex") + 4;
    const bytes = Math.clz32(growing[size]) - 23;
    growing.fill(0xff, size, size + bytes)[size] >>= bytes - 1;
  }
  const file = path.join(world.folder, "grows.mkv");
  await writeFile(file, growing.subarray(0, 0.97 * clip.length));
  const page = await opened(world, "grows.mkv");
  await page.waitForFunction(() => document.querySelector("kinora-player").layers.length === 3);
  await page.waitForTimeout(1500); // it looks for more, which is not there
  assert.deepEqual(await page.player("return [player.duration, player.readyState, player.error]"), [0, 3, null]);
  await writeFile(file, clip);
  await shown(page);
  assert.ok(near(await page.player("return player.duration"), 11 / 30));
  assert.equal(await page.player("return player.error"), null);
  await closed(page);
});

claim("WebGL that is lost is drawn without, and again with it when it is restored", async (world) => {
  const page = await opened(world, "nowhere.mkv");
  await page.getByRole("alert").waitFor();
  // Workers in which the test can take WebGL away.
  await page.evaluate(() => {
    const hook = `const get = OffscreenCanvas.prototype.getContext;
      OffscreenCanvas.prototype.getContext = function (...words) {
        const context = get.apply(this, words);
        globalThis.lost = context.getExtension("WEBGL_lose_context");
        return context;
      };`;
    const file = (text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
    const Plain = Worker;
    globalThis.Worker = class extends Plain {
      constructor(address, options) {
        super(file(`import "${file(hook)}"; import "${address}";`), options);
      }
    };
  });
  await page.player("player.drawnBy = 'webgl'; player.hidden = true; player.src = given", `${world.served.address}carry_box.mkv`);
  await page.waitForFunction(() => document.querySelector("kinora-player").stage?.complete);
  const drawn = () =>
    page.player(`const request = { ...player.stage.wanted, camera: { pose: null, width: 40, height: 30 }, preview: true, withDepth: false };
      return player.stage.draw(request).then(({ by, color }) => [by, color.filter((_, i) => i % 4 === 3).some((alpha) => alpha > 0)])`);
  const inWorkers = (body) => Promise.all(page.workers().map((worker) => worker.evaluate(body).catch(() => undefined))); // some have ended
  assert.deepEqual(await drawn(), ["webgl", true]);
  await inWorkers("globalThis.lost?.loseContext()");
  while ((await drawn())[0] !== "cpu") await page.waitForTimeout(20);
  assert.deepEqual(await drawn(), ["cpu", true]);
  await inWorkers("globalThis.lost?.restoreContext()");
  while ((await drawn())[0] !== "webgl") await page.waitForTimeout(20);
  assert.deepEqual(await drawn(), ["webgl", true]);
  await closed(page);
});
