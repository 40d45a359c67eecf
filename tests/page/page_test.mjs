// Plays a clip in a browser as people do. FOLDER holds carry_box.mkv and native/000006.png, its picture by `kinora render`.
// Screenshots go to FOLDER/seen. usage: node page_test.mjs KINORA FOLDER [WORDS]   WORDS: of the claims that are tested
import assert from "node:assert/strict";
import { mkdir, readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { claim, launch, missing, root, runClaims, serve, serveByNginx, serveFaults } from "./browser.mjs";
import { closed, keep, opened, psnr, rests, shown } from "./pages.mjs";
import "./decoding_claims.mjs";
import "./people_claims.mjs";
import "./sound_claims.mjs";
import "./streaming_claims.mjs";

const reason = missing();
if (reason) {
  console.log(`skipped: ${reason}`);
  process.exit(77);
}
const [kinora, folder, words] = process.argv.slice(2);

claim("the list of clips leads to one that plays", async ({ browser, served, seen }) => {
  const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
  page.setDefaultTimeout(90000);
  await page.goto(served.address);
  await page.getByRole("link", { name: "carry_box.mkv", exact: true }).click();
  await shown(page);
  await page.waitForFunction(() => !document.querySelector("kinora-player").paused);
  await page.getByRole("button", { name: "Pause" }).click();
  await page.getByRole("button", { name: "Settings" }).click();
  await page.getByRole("checkbox", { name: "object" }).uncheck();
  await page.screenshot({ path: path.join(seen, "menu.png") });
  await page.close();
});

claim("at rest it shows the picture of kinora render", async (world) => {
  const page = await opened(world, "carry_box.mkv", {}, "#t=0.2001");
  await shown(page);
  await rests(page);
  await page.screenshot({ path: path.join(world.seen, "rest.png") });
  await page.evaluate(async (address) => {
    const bitmap = await createImageBitmap(await (await fetch(address)).blob(), { premultiplyAlpha: "none" });
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    canvas.getContext("2d").drawImage(bitmap, 0, 0);
    globalThis.kept = { native: canvas.getContext("2d").getImageData(0, 0, bitmap.width, bitmap.height).data };
  }, `${world.served.address}native/000006.png`);
  await keep(page, "page");
  const similarity = await psnr(page, "page", "native");
  console.log(`  ${similarity.toFixed(1)} dB`);
  assert.ok(similarity >= 40, `${similarity} dB`);
  await closed(page);
});

claim("dragging turns, the wheel comes nearer, Home goes back", async (world) => {
  const page = await opened(world, "carry_box.mkv", {}, "#t=0.2");
  await shown(page);
  await rests(page);
  await keep(page, "before");
  assert.equal(await page.player("return player.camera"), null);
  await page.mouse.move(320, 200);
  await page.mouse.down();
  await page.mouse.move(400, 230, { steps: 5 });
  await page.mouse.up();
  const turned = await page.player("return player.camera");
  await page.mouse.wheel(0, -300);
  await page.waitForFunction((was) => document.querySelector("kinora-player").camera.position[2] !== was, turned.position[2]);
  const near = await page.player("return player.camera");
  const far = (view) => Math.hypot(...view.position.map((x, i) => x - view.target[i]));
  assert.ok(Math.abs(turned.position[0]) > 0.05, JSON.stringify(turned));
  assert.ok(far(near) < 0.9 * far(turned));
  await rests(page);
  await page.screenshot({ path: path.join(world.seen, "turned.png") });
  await keep(page, "turned");
  assert.ok((await psnr(page, "turned", "before")) < 30);
  await page.keyboard.press("Home");
  await rests(page);
  await keep(page, "after");
  assert.equal(await psnr(page, "after", "before"), 99);
  await closed(page);
});

claim("a link shows the same moment from the same place", async (world) => {
  const page = await opened(world, "carry_box.mkv", {}, "#t=0.3&cam=0.4,-0.2,0.1,0.1,0,2,0,-1,0");
  await shown(page);
  await rests(page);
  assert.equal(await page.player("return player.place"), "#t=0.3&cam=0.4,-0.2,0.1,0.1,0,2,0,-1,0");
  await closed(page);
});

claim("it plays to its end, seeks and repeats with the events of <video>", async (world) => {
  const page = await opened(world, "carry_box.mkv", {}, "#t=0");
  await shown(page);
  const events = await page.player(`
    player.loop = false;
    const told = [];
    for (const name of ["play", "playing", "timeupdate", "ended", "pause", "seeking", "seeked"])
      player.addEventListener(name, () => told.push(name));
    return new Promise((resolve) => {
      player.addEventListener("ended", () => { player.currentTime = 0.1; }, { once: true });
      player.addEventListener("seeked", () => resolve(told), { once: true });
      player.play();
    });`);
  for (const name of ["play", "playing", "timeupdate", "pause", "ended", "seeking", "seeked"]) {
    assert.ok(events.includes(name), `${name} is not among ${events}`);
  }
  assert.ok(Math.abs((await page.player("return player.currentTime")) - 0.1) < 1e-6);
  await page.player("player.loop = true; player.play(); return new Promise((resolve) => setTimeout(resolve, 1000))");
  assert.equal(await page.player("return player.paused"), false);
  await closed(page);
});

claim("what cannot be played is said in the element and by an error event with a code", async (world) => {
  const page = await opened(world);
  const wrong = {
    [`${world.served.address}none.txt`]: [4, /is not a Kinora file/],
    [`${world.served.address}empty.mkv`]: [4, /is not a Kinora file/],
    [`${world.served.address}cut.mkv`]: [3, /./],
    [`${world.served.address}nowhere.mkv`]: [2, /404/],
    [`${world.faults.address}/cut_off.mkv`]: [2, /connection ended/],
    [`${world.faults.address}/not_shared.mkv`]: [2, /CORS/],
  };
  for (const [address, [code, sentence]] of Object.entries(wrong)) {
    const error = await page.player(
      `return new Promise((resolve) => {
        player.addEventListener("error", (event) => resolve({ told: event.message, ...player.error }), { once: true });
        player.src = given;
      })`,
      address,
    );
    assert.equal(error.code, code, `${address}: ${JSON.stringify(error)}`);
    assert.match(error.told, sentence);
    assert.equal(await page.getByRole("alert").textContent(), error.message);
  }
  await page.screenshot({ path: path.join(world.seen, "fault.png") });
  await page.player(`player.src = given`, `${world.served.address}carry_box.mkv`);
  await shown(page);
  await closed(page);
});

claim("two players play side by side, and one that is removed while it loads says nothing", async (world) => {
  const page = await opened(world);
  await page.evaluate((addresses) => {
    const [second, third] = addresses.map((src) => Object.assign(document.createElement("kinora-player"), { src }));
    document.querySelector("kinora-player").style.height = second.style.height = "50%";
    document.body.append(second, third);
    setTimeout(() => third.remove(), 100);
  }, [`${world.served.address}carry_box.mkv`, `${world.faults.address}/slow.mkv`]);
  await page.waitForFunction(() => {
    const all = [...document.querySelectorAll("kinora-player")];
    return all.length === 2 && all.every((player) => player.readyState === 4);
  });
  await closed(page);
});

claim("on a phone one finger turns and two come nearer", async (world) => {
  const phone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, deviceScaleFactor: 2 };
  const page = await opened(world, "carry_box.mkv", phone, "#t=0.2");
  await shown(page);
  const session = await page.context().newCDPSession(page);
  const touch = (type, ...points) => session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y, id]) => ({ x, y, id })) });
  await touch("touchStart", [200, 400, 1]);
  await touch("touchMove", [230, 405, 1]);
  await touch("touchMove", [260, 410, 1]);
  const turned = await page.player("return player.camera");
  assert.ok(turned, "one finger did not turn");
  await touch("touchStart", [260, 410, 1], [160, 410, 2]);
  await touch("touchMove", [280, 410, 1], [140, 410, 2]);
  await touch("touchMove", [300, 410, 1], [120, 410, 2]);
  await touch("touchEnd");
  const near = await page.player("return player.camera");
  const far = (view) => Math.hypot(...view.position.map((x, i) => x - view.target[i]));
  assert.ok(far(near) < 0.8 * far(turned), `${far(turned)} to ${far(near)} m`);
  await page.waitForTimeout(1500);
  await page.screenshot({ path: path.join(world.seen, "phone.png") });
  await closed(page);
});

claim("WebGL draws the picture of the CPU", async (world) => {
  const page = await opened(world, "carry_box.mkv", {}, "#t=0.2");
  await shown(page);
  const [by, similarity] = await page.evaluate(async (src) => {
    const first = document.querySelector("kinora-player");
    const second = Object.assign(document.createElement("kinora-player"), { src, drawnBy: "webgl" });
    const ready = new Promise((resolve) => {
      for (const event of ["loadedmetadata", "durationchange"]) {
        second.addEventListener(event, () => second.stage.complete && resolve());
      }
    });
    second.hidden = true; // a program that draws in the GPU's place takes long: one small picture is enough
    document.body.append(second);
    await ready;
    const camera = { pose: null, width: 160, height: 120 };
    const request = { ...first.stage.wanted, camera, preview: true, withDepth: false };
    const [cpu, webgl] = await Promise.all([first, second].map((player) => player.stage.draw(request)));
    let sum = 0;
    for (let i = 0; i < cpu.color.length; i += 4) {
      for (let c = 0; c < 3; ++c) {
        sum += ((cpu.color[i + c] * cpu.color[i + 3] - webgl.color[i + c] * webgl.color[i + 3]) / 255) ** 2;
      }
    }
    return [webgl.by, 10 * Math.log10(255 ** 2 / (sum / (0.75 * cpu.color.length)))];
  }, `${world.served.address}carry_box.mkv`);
  console.log(`  ${similarity.toFixed(1)} dB`);
  assert.equal(by, "webgl");
  assert.ok(similarity >= 36, `${similarity} dB`);
  await closed(page);
});

claim("in a scene of three.js it hides what is behind it and is hidden by what is before it", async (world) => {
  const page = await world.browser.newPage({ viewport: { width: 320, height: 240 } });
  page.setDefaultTimeout(90000);
  await page.goto(`${world.source.address}web/examples/01_in_a_three_scene.html?clip=${encodeURIComponent(`${world.served.address}carry_box.mkv`)}`);
  await page.waitForFunction(() => globalThis.example?.clip.material.uniforms.color.value.image.width > 1);
  const counts = await page.evaluate(async () => {
    const { scene, camera, renderer, clip, ring, player } = globalThis.example;
    renderer.setAnimationLoop(null);
    player.pause();
    player.currentTime = 0;
    const { x, y, z } = ring.position;
    camera.position.set(x, y + 0.5, z + 2.2);
    camera.lookAt(x, y, z);
    // Pixels that look otherwise with the ring than without.
    const seen = () => {
      const gl = renderer.getContext();
      const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
      const pictures = [true, false].map((visible) => {
        ring.visible = visible;
        renderer.render(scene, camera);
        const pixels = new Uint8Array(4 * width * height);
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        return pixels;
      });
      ring.visible = true;
      let count = 0;
      for (let i = 0; i < width * height; ++i) {
        count += [0, 1, 2].some((c) => pictures[0][4 * i + c] !== pictures[1][4 * i + c]) ? 1 : 0;
      }
      return count;
    };
    for (let i = 0; i < 2; ++i) { // the first may be one that was asked for before
      renderer.render(scene, camera);
      await clip.drawn();
    }
    const together = seen();
    clip.visible = false;
    const alone = seen();
    clip.visible = true;
    renderer.render(scene, camera);
    return { together, alone };
  });
  await page.screenshot({ path: path.join(world.seen, "three.png") });
  const part = counts.together / counts.alone;
  assert.ok(part > 0.5 && part < 0.97, `the ring shows ${counts.together} of ${counts.alone} pixels`);
  await page.close();
});

const clip = await readFile(path.join(folder, "carry_box.mkv"));
await writeFile(path.join(folder, "cut.mkv"), clip.subarray(0, clip.length * 0.7));
await writeFile(path.join(folder, "empty.mkv"), "");
await writeFile(path.join(folder, "none.txt"), "no clip\n".repeat(100));
const seen = path.join(folder, "seen");
await mkdir(seen, { recursive: true });
const served = await serve(kinora, folder);
const source = await serve(kinora, root);
const faults = await serveFaults(clip);
const nginx = await serveByNginx(folder);
const browser = await launch();
const wrong = await runClaims({ browser, served, source, faults, nginx, kinora, folder, seen }, words);
await browser.close();
served.stop();
source.stop();
faults.stop();
nginx?.stop();
process.exit(wrong === 0 ? 0 : 1);
