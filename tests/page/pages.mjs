// What people do with a page that plays a clip.
import assert from "node:assert/strict";

/** A page with a clip in it, that fails its test for whatever it says on its console. */
export async function opened({ browser, served }, clip = "carry_box.mkv", options = {}, hash = "") {
  const page = await browser.newPage({ viewport: { width: 640, height: 480 }, ...options });
  page.setDefaultTimeout(90000); // what is slow is not wrong
  page.said = [];
  page.on("pageerror", (error) => page.said.push(String(error)));
  await page.goto(`${served.address}.kinora/index.html?clip=${encodeURIComponent(new URL(clip, served.address))}${hash}`);
  page.player = (body, argument) =>
    page.locator("kinora-player").evaluate((player, [text, given]) => new Function("player", "given", text)(player, given), [body, argument]);
  return page;
}
/** All of the clip has come. */
export const shown = (page) => page.waitForFunction(() => document.querySelector("kinora-player").readyState === 4);
/** The full picture at rest is shown. */
export async function rests(page) {
  await page.player("player.pause()");
  await page.waitForFunction(() => document.querySelector("kinora-player").stage.settled, null, { polling: 100 });
}
/** Remembers the picture that is shown, in the page, under a name. */
export const keep = (page, name) =>
  page.player(`const c = player.shadowRoot.querySelector("canvas");
    (globalThis.kept ??= {})[given] = c.getContext("2d").getImageData(0, 0, c.width, c.height).data`, name);
/** dB between two pictures on black that were kept. */
export const psnr = (page, ...names) =>
  page.evaluate((given) => {
    const [a, b] = given.map((name) => globalThis.kept[name]);
    if (a.length !== b.length) return 0;
    let sum = 0;
    for (let i = 0; i < a.length; i += 4) {
      for (let c = 0; c < 3; ++c) sum += ((a[i + c] * a[i + 3] - b[i + c] * b[i + 3]) / 255) ** 2;
    }
    return Math.min(99, 10 * Math.log10(255 ** 2 / (sum / (0.75 * a.length))));
  }, names);
/** Nothing was said on its console. */
export const closed = async (page) => {
  const { said } = page;
  await page.close();
  assert.deepEqual(said, []);
};
