// A clip's sound, heard while its pictures are seen. The clock goes by what is heard.
import { steadySeconds, type PlaybackClock } from "./clock.js";
import type { Sound } from "./messages.js";
import { oggOfOpus } from "./ogg.js";

const pieceSeconds = 10; // that are decoded at once: memory holds two of these
const runIn = 0.1; // seconds that a decoder needs before what it gives is right
const jump = 0.05; // seconds of the clock, from which on sound is begun again

/** Its packets that begin by then; null: there are none. */
export function soundUpTo(sound: Sound, time: number): Sound | null {
  const behind = sound.times.findIndex((begin) => begin > time);
  if (behind < 0) return sound;
  return behind === 0 ? null : { ...sound, times: sound.times.slice(0, behind), ends: sound.ends.slice(0, behind) };
}

/** Decoded sound of packets that follow each other. */
interface Piece {
  begin: number; // seconds of the clip, of the first sample
  from: number; // that are to be heard
  to: number;
  buffer: AudioBuffer;
}

export class SoundPlayback {
  muted = false;
  #volume = 1;
  #sound: Sound | null = null;
  #context: AudioContext | null = null;
  #gain: GainNode | null = null;
  #pieces = new Map<number, Promise<Piece | null>>();
  #playing = new Map<number, AudioBufferSourceNode | null>(); // null: it is still decoded
  #started: { from: number; at: number } | null = null; // seconds of the clip, and of the context
  #given = false; // up

  constructor(private readonly told: (why: string) => void) {}

  get there(): boolean {
    return this.#sound !== null;
  }

  /** Of the clip that is played, or more of it. */
  setSound(sound: Sound | null): void {
    this.#sound = sound;
    this.#pieces.clear(); // the last may have been cut
    if (!sound || sound.codec === "A_OPUS") return;
    this.#giveUp(`its sound is ${sound.codec}, which is not played in a page; Opus is`);
  }

  get volume(): number {
    return this.#volume;
  }
  /** 0 to 1. */
  set volume(volume: number) {
    this.#volume = volume;
    if (this.#gain) this.#gain.gain.value = volume;
  }

  /** To be called many times a second: plays on from where the clock stands, or stops. Other speeds are silent. */
  follow(clock: PlaybackClock): void {
    const wanted = clock.playing && clock.rate === 1 && !clock.starved && !clock.ended;
    if (!wanted || this.muted || !this.#sound || this.#given || !this.#runs()) return this.#stop(clock);
    if (this.#started && Math.abs(this.#now() - clock.time - this.#latency()) > jump) this.#stop(clock);
    if (!this.#started) this.#start(clock);
    const piece = Math.floor(this.#now() / pieceSeconds);
    this.#schedule(piece);
    this.#schedule(piece + 1);
    for (const old of [...this.#pieces.keys()]) if (old < piece || old > piece + 1) this.#pieces.delete(old);
  }

  close(): void {
    this.#silence();
    void this.#context?.close();
    this.#context = null;
  }

  /** Browsers are silent until somebody has touched the page. */
  #runs(): boolean {
    if (!this.#context) {
      this.#context = new AudioContext();
      this.#gain = this.#context.createGain();
      this.#gain.gain.value = this.#volume;
      this.#gain.connect(this.#context.destination);
    }
    if (this.#context.state === "suspended") void this.#context.resume().catch(() => undefined);
    return this.#context.state === "running";
  }

  #latency(): number {
    return this.#context!.baseLatency || 0;
  }

  /** Seconds of the clip that are given to the loudspeaker. */
  #now(): number {
    return this.#started!.from + this.#context!.currentTime - this.#started!.at;
  }

  #start(clock: PlaybackClock): void {
    const context = this.#context!;
    clock.setMaster(() => context.currentTime);
    this.#started = { from: clock.time + this.#latency(), at: context.currentTime };
  }

  #stop(clock: PlaybackClock): void {
    if (!this.#started) return;
    clock.setMaster(steadySeconds);
    this.#silence();
  }

  #silence(): void {
    for (const node of this.#playing.values()) node?.stop();
    this.#playing.clear();
    this.#started = null;
  }

  #schedule(number: number): void {
    if (this.#playing.has(number)) return;
    this.#playing.set(number, null);
    if (!this.#pieces.has(number)) this.#pieces.set(number, this.#decoded(number));
    const started = this.#started;
    void this.#pieces.get(number)!.then((piece) => {
      if (piece && this.#started === started) this.#play(number, piece);
    });
  }

  #play(number: number, piece: Piece): void {
    const context = this.#context!;
    const from = Math.max(piece.from, this.#now());
    if (from >= piece.to) return;
    const node = new AudioBufferSourceNode(context, { buffer: piece.buffer });
    node.connect(this.#gain!);
    const { from: began, at } = this.#started!;
    node.start(at + from - began, from - piece.begin, piece.to - from);
    this.#playing.set(number, node);
  }

  /** null: there is no sound there. */
  async #decoded(number: number): Promise<Piece | null> {
    const { times, setup, delay } = this.#sound!;
    const [from, to] = [number * pieceSeconds, (number + 1) * pieceSeconds];
    const first = times.findIndex((time) => time - delay >= from - runIn);
    if (first < 0 || times[first]! - delay >= to) return null;
    let end = first;
    while (end < times.length && times[end]! - delay < to) ++end;
    const packets = Array.from({ length: end - first }, (_, i) => this.#packet(first + i));
    try {
      const buffer = await this.#context!.decodeAudioData(oggOfOpus(setup, packets).buffer);
      return { begin: times[first]! - delay, from, to, buffer };
    } catch (thrown) {
      this.#giveUp(`this browser does not play its sound: ${String(thrown)}`);
      return null;
    }
  }

  #packet(i: number): Uint8Array {
    const { bytes, ends } = this.#sound!;
    return bytes.subarray(i === 0 ? 0 : ends[i - 1]!, ends[i]!);
  }

  #giveUp(why: string): void {
    if (!this.#given) this.told(why);
    this.#given = true;
  }
}
