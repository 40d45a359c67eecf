// Opus packets as an Ogg file (RFC 3533, RFC 7845), which is what browsers decode.

const packetsOfPage = 50; // one second and fewer than 255 segments of usual packets
const samplesPerSecond = 48000; // of Opus, always

/** `setup`: OpusHead. The file says that no sample is to be skipped: its first is the first packet's. */
export function oggOfOpus(setup: Uint8Array, packets: Uint8Array[]): Uint8Array<ArrayBuffer> {
  const head = setup.slice();
  head.fill(0, 10, 12); // pre-skip
  const pages = [page(0, 0, 2, [head]), page(1, 0, 0, [tags()])];
  let samples = 0;
  for (let first = 0; first < packets.length; ) {
    const [start, end] = [first, endOfPage(packets, first)];
    for (; first < end; ++first) samples += samplesOf(packets[first]!);
    pages.push(page(pages.length, samples, end === packets.length ? 4 : 0, packets.slice(start, end)));
  }
  const file = new Uint8Array(pages.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const made of pages) {
    file.set(made, at);
    at += made.length;
  }
  return file;
}

/** Of an Opus packet (RFC 6716, 3.1). */
function samplesOf(packet: Uint8Array): number {
  const [toc = 0, count = 0] = packet;
  const config = toc >> 3;
  const milliseconds =
    config < 12 ? [10, 20, 40, 60][config % 4]! : config < 16 ? [10, 20][config % 2]! : [2.5, 5, 10, 20][config % 4]!;
  const frames = [1, 2, 2, count & 63][toc & 3]!;
  return (milliseconds * frames * samplesPerSecond) / 1000;
}

const segmentsOf = (packet: Uint8Array): number => Math.floor(packet.length / 255) + 1;

/** A page has at most 255 segments; a packet that has more does not exist in Opus. */
function endOfPage(packets: Uint8Array[], first: number): number {
  let end = first;
  let segments = 0;
  while (end < packets.length && end - first < packetsOfPage) {
    segments += segmentsOf(packets[end]!);
    if (segments > 255 && end > first) break;
    ++end;
  }
  return end;
}

function tags(): Uint8Array {
  const text = new TextEncoder().encode("OpusTags\0\0\0\0Kinora\0\0\0\0");
  text[8] = 6; // length of the name that follows
  return text;
}

function page(number: number, samples: number, flags: number, packets: Uint8Array[]): Uint8Array {
  const lacing = packets.flatMap((packet) => [...new Array<number>(segmentsOf(packet) - 1).fill(255), packet.length % 255]);
  const size = packets.reduce((sum, { length }) => sum + length, 27 + lacing.length);
  const bytes = new Uint8Array(size);
  const view = new DataView(bytes.buffer);
  bytes.set([0x4f, 0x67, 0x67, 0x53, 0, flags]); // OggS
  view.setBigUint64(6, BigInt(Math.round(samples)), true);
  view.setUint32(14, 1, true); // of the stream
  view.setUint32(18, number, true);
  bytes[26] = lacing.length;
  bytes.set(lacing, 27);
  let at = 27 + lacing.length;
  for (const packet of packets) {
    bytes.set(packet, at);
    at += packet.length;
  }
  view.setUint32(22, checksum(bytes), true);
  return bytes;
}

const table = Uint32Array.from({ length: 256 }, (_, i) => {
  let r = i << 24;
  for (let bit = 0; bit < 8; ++bit) r = r & 0x80000000 ? (r << 1) ^ 0x04c11db7 : r << 1;
  return r >>> 0;
});

function checksum(bytes: Uint8Array): number {
  let crc = 0;
  for (const byte of bytes) crc = ((crc << 8) ^ table[(crc >>> 24) ^ byte]!) >>> 0;
  return crc;
}
