// A clip's sound in a page.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import path from "node:path";
import { claim } from "./browser.mjs";
import { closed, opened, shown } from "./pages.mjs";

/** The clip with two seconds of 440 Hz; null if the programs that make it are missing. */
function withSound(folder) {
  const [tone, clip] = ["tone.opus", "sound.mkv"].map((name) => path.join(folder, name));
  const input = ["-v", "error", "-y", "-f", "lavfi", "-i", "sine=frequency=440:duration=2"];
  try {
    execFileSync("ffmpeg", [...input, "-c:a", "libopus", tone]);
    execFileSync("mkvmerge", ["-q", "--disable-lacing", "-o", clip, path.join(folder, "carry_box.mkv"), tone]);
    return "sound.mkv";
  } catch (error) {
    if (error.code === "ENOENT") return null;
    throw error;
  }
}

claim("sound is heard with the pictures, and not when it is muted", async (world) => {
  const name = withSound(world.folder);
  if (!name) return console.log("  not tested: there is no ffmpeg or mkvmerge; run scripts/setup");
  const page = await opened(world, name, {}, "#t=0"); // stands still until it is told to play
  await shown(page);
  await page.evaluate(() => {
    globalThis.heard = [];
    const start = AudioBufferSourceNode.prototype.start;
    AudioBufferSourceNode.prototype.start = function (when, offset, duration) {
      const samples = this.buffer.getChannelData(0);
      const begin = Math.floor((offset + 0.05) * this.buffer.sampleRate);
      let [power, crossings] = [0, 0];
      const count = this.buffer.sampleRate / 5;
      for (let i = begin; i < begin + count; ++i) {
        power += samples[i] ** 2 / count;
        if (samples[i] < 0 !== samples[i + 1] < 0) ++crossings;
      }
      globalThis.heard.push({ power, hertz: 2.5 * crossings });
      return start.call(this, when, offset, duration);
    };
  });
  await page.player("player.loop = true");
  await page.getByRole("button", { name: "Play" }).click(); // browsers are silent before
  await page.waitForFunction(() => globalThis.heard.length > 0);
  const [{ power, hertz }] = await page.evaluate(() => globalThis.heard);
  assert.ok(power > 1e-4, `power ${power}`);
  assert.ok(Math.abs(hertz - 440) < 15, `${hertz} Hz`);
  const repeats = await page.evaluate(() => globalThis.heard.length);
  await page.waitForFunction((before) => globalThis.heard.length > before, repeats); // the clip begins again, and so does it
  await page.getByRole("button", { name: "Mute" }).click();
  assert.equal(await page.player("return player.muted"), true);
  const before = await page.evaluate(() => globalThis.heard.length);
  await page.waitForTimeout(1000); // the clip begins again at least twice
  assert.equal(await page.evaluate(() => globalThis.heard.length), before);
  assert.equal(await page.player("return player.paused"), false);
  await page.screenshot({ path: path.join(world.seen, "muted.png") });
  await closed(page);
});

claim("a clip without sound offers nothing to mute", async (world) => {
  const page = await opened(world);
  await shown(page);
  assert.equal(await page.getByRole("button", { name: "Mute" }).count(), 0);
  await closed(page);
});
