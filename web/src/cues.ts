// The index of a Matroska file (RFC 9559): which cluster has what is shown at a time.

const ids = { segment: 0x18538067, seekHead: 0x114d9b74, seek: 0x4dbb, seekId: 0x53ab, seekPosition: 0x53ac } as const;
const info = { element: 0x1549a966, timestampScale: 0x2ad7b1 } as const;
const cues = { element: 0x1c53bb6b, point: 0xbb, time: 0xb3, positions: 0xb7, track: 0xf7, cluster: 0xf1 } as const;
const usualScale = 1e6; // nanoseconds

interface Element {
  id: number;
  body: number;
  end: number; // Infinity: it does not say
}

/** What the front of a file says of its index. */
export interface Front {
  segment: number; // byte from which positions count
  cues: number | null; // byte of the index; null: it does not say
  seconds: number; // of one tick
}

/** Where to go on for a time. */
export interface Place {
  from: number; // byte of a cluster
  until: number; // of the first behind what is needed for that time; Infinity: it is in the last cluster
}

/** null: these are not the first bytes of a Matroska file, or too few. */
export function frontOf(bytes: Uint8Array): Front | null {
  let segment: Element | null = null;
  for (let at = 0; !segment; ) {
    const element = elementAt(bytes, at);
    if (!element) return null;
    if (element.id === ids.segment) segment = element;
    at = element.end;
  }
  const front: Front = { segment: segment.body, cues: null, seconds: 1e-9 * usualScale };
  for (const element of elementsIn(bytes, segment.body, segment.end)) {
    if (element.id === ids.seekHead) {
      for (const seek of elementsIn(bytes, element.body, element.end)) {
        if (numberIn(bytes, seek, ids.seekId) !== cues.element) continue;
        const position = numberIn(bytes, seek, ids.seekPosition);
        if (position !== null) front.cues = segment.body + position;
      }
    }
    if (element.id === info.element) front.seconds = 1e-9 * (numberIn(bytes, element, info.timestampScale) ?? usualScale);
  }
  return front;
}

export class Cues {
  private constructor(private readonly tracks: { seconds: number; cluster: number }[][]) {}

  /** `bytes`: a piece of the file with the index in it. null: it is not, or has nothing. */
  static read(bytes: Uint8Array, front: Front): Cues | null {
    for (let at = 0; at + 4 <= bytes.length; ++at) {
      if (bytes[at] !== cues.element >>> 24 || numberAt(bytes, at, at + 4) !== cues.element) continue;
      const element = elementAt(bytes, at);
      if (!element || element.end > bytes.length) continue;
      const found = Cues.#parse(bytes, element, front);
      if (found) return found;
    }
    return null;
  }

  static #parse(bytes: Uint8Array, index: Element, front: Front): Cues | null {
    const tracks = new Map<number, { seconds: number; cluster: number }[]>();
    for (const point of elementsIn(bytes, index.body, index.end)) {
      const time = point.id === cues.point ? numberIn(bytes, point, cues.time) : null;
      if (time === null) continue;
      for (const positions of elementsIn(bytes, point.body, point.end)) {
        if (positions.id !== cues.positions) continue;
        const track = numberIn(bytes, positions, cues.track);
        const cluster = numberIn(bytes, positions, cues.cluster);
        if (track === null || cluster === null) continue;
        if (!tracks.has(track)) tracks.set(track, []);
        tracks.get(track)!.push({ seconds: time * front.seconds, cluster: front.segment + cluster });
      }
    }
    // What has a single entry is of no time, or can be entered at its beginning alone.
    const several = [...tracks.values()].filter((entries) => entries.length > 1);
    for (const entries of several) entries.sort((a, b) => a.seconds - b.seconds);
    return several.length > 0 ? new Cues(several) : null;
  }

  placeOf(seconds: number): Place {
    const half = 5e-4; // times in the index are rounded
    const before = this.tracks.map((entries) => entries.filter((e) => e.seconds <= seconds + half).at(-1) ?? entries[0]!);
    const from = Math.min(...before.map(({ cluster }) => cluster));
    const last = Math.max(...before.map(({ cluster }) => cluster));
    const later = this.tracks.flat().filter(({ cluster }) => cluster > last);
    return { from, until: Math.min(...later.map(({ cluster }) => cluster)) };
  }
}

function* elementsIn(bytes: Uint8Array, from: number, end: number): Generator<Element> {
  for (let at = from; at < end; ) {
    const element = elementAt(bytes, at);
    if (!element) return;
    if (element.end <= bytes.length) yield element;
    at = element.end;
  }
}

function elementAt(bytes: Uint8Array, at: number): Element | null {
  const idLength = lengthAt(bytes, at);
  const sizeLength = lengthAt(bytes, at + idLength);
  const body = at + idLength + sizeLength;
  if (idLength > 4 || sizeLength > 8 || body > bytes.length) return null;
  const marker = 2 ** (7 * sizeLength);
  let size = bytes[at + idLength]! & (0xff >> sizeLength); // without its marker, as more than 53 bits cannot be counted
  for (let i = at + idLength + 1; i < body; ++i) size = 256 * size + bytes[i]!;
  return { id: numberAt(bytes, at, at + idLength), body, end: size >= marker - 1 ? Infinity : body + size };
}

/** Of the first child of that kind. */
function numberIn(bytes: Uint8Array, parent: Element, id: number): number | null {
  for (const child of elementsIn(bytes, parent.body, parent.end)) {
    if (child.id === id && child.end - child.body <= 8) return numberAt(bytes, child.body, child.end);
  }
  return null;
}

/** Bytes of a variable-length integer; 9: none begins here. */
const lengthAt = (bytes: Uint8Array, at: number) => (at < bytes.length ? Math.clz32(bytes[at]!) - 23 : 9);

function numberAt(bytes: Uint8Array, from: number, end: number): number {
  let value = 0;
  for (let at = from; at < end; ++at) value = 256 * value + bytes[at]!;
  return value;
}
