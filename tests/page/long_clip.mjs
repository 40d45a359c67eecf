// A clip of several clusters.
import { execFileSync } from "node:child_process";
import { mkdtemp, readFile, rename, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";

/** Of FOLDER's carry_box.mkv, 32 times over, some 13 seconds: its bytes, and its clusters' first bytes and seconds. */
export async function longClip(kinora, folder) {
  const work = await mkdtemp(path.join(tmpdir(), "kinora-long-"));
  const [clip, longer] = ["clip.mkv", "longer.mkv"].map((name) => path.join(work, name));
  for (let doubled = 0, from = path.join(folder, "carry_box.mkv"); doubled < 5; ++doubled, from = clip) {
    execFileSync(kinora, ["join", from, from, longer, "--quiet"], { stdio: "ignore" });
    await rename(longer, clip);
  }
  const bytes = await readFile(clip);
  await rm(work, { recursive: true });
  const clusters = [];
  for (let at = bytes.indexOf("1f43b675", 0, "hex"); at >= 0; at = bytes.indexOf("1f43b675", at + 1, "hex")) {
    const timestamp = at + 5 + Math.clz32(bytes[at + 4]) - 24; // behind the cluster's size
    if (bytes[timestamp] !== 0xe7) continue;
    clusters.push({ at, seconds: bytes.readUIntBE(timestamp + 2, bytes[timestamp + 1] & 0x7f) / 1000 });
  }
  return { bytes, clusters };
}
