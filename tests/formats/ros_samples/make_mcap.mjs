// Makes the MCAP files of this folder with npm's @mcap/core and @foxglove/rosmsg2-serialization, and the programs zstd
// and lz4. usage: node make_mcap.mjs FOLDER
import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { McapWriter } from "@mcap/core";
import { parse } from "@foxglove/rosmsg";
import { MessageWriter } from "@foxglove/rosmsg2-serialization";

const WIDTH = 16, HEIGHT = 12, FRAMES = 3;

const TIME = "builtin_interfaces/Time stamp\nstring frame_id";
const HEADER = `================================================================================
MSG: std_msgs/Header
${TIME}
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
`;
const IMAGE = `std_msgs/Header header
uint32 height
uint32 width
string encoding
uint8 is_bigendian
uint32 step
uint8[] data
${HEADER}`;
const ROI = `================================================================================
MSG: sensor_msgs/RegionOfInterest
uint32 x_offset
uint32 y_offset
uint32 height
uint32 width
bool do_rectify
`;
const CAMERA_INFO = `std_msgs/Header header
uint32 height
uint32 width
string distortion_model
float64[] d
float64[9] k
float64[9] r
float64[12] p
uint32 binning_x
uint32 binning_y
sensor_msgs/RegionOfInterest roi
${HEADER}${ROI}`;
const TRANSFORMS = `geometry_msgs/TransformStamped[] transforms
================================================================================
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
================================================================================
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
${HEADER}`;

function color(frame) {
  const out = new Uint8Array(3 * WIDTH * HEIGHT);
  for (let v = 0; v < HEIGHT; ++v)
    for (let u = 0; u < WIDTH; ++u)
      for (let c = 0; c < 3; ++c) out[3 * (WIDTH * v + u) + 2 - c] = 7 * u + 13 * v + 50 * c + 11 * frame; // BGR
  return out;
}

/** Metres as floats. */
function depth(frame) {
  const out = new Float32Array(WIDTH * HEIGHT);
  for (let v = 0; v < HEIGHT; ++v)
    for (let u = 0; u < WIDTH; ++u)
      out[WIDTH * v + u] = (u + v + frame) % 7 === 0 ? NaN : (1000 + 10 * u + 3 * v + 100 * frame) / 1000;
  return new Uint8Array(out.buffer);
}

function header(frame, frame_id) {
  return { stamp: { sec: 1600000000, nanosec: 250000000 + frame * 31250000 }, frame_id };
}

const image = (frame, encoding, step, data, id) => ({
  header: header(frame, id), height: HEIGHT, width: WIDTH, encoding, is_bigendian: 0, step, data });
const camera = (frame, fx, id) => ({
  header: header(frame, id), height: HEIGHT, width: WIDTH, distortion_model: "plumb_bob", d: [0.1, -0.2, 0.001, 0.002, 0.05],
  k: [fx, 0, 7.5, 0, 21, 5.5, 0, 0, 1], r: new Array(9).fill(0), p: new Array(12).fill(0), binning_x: 0, binning_y: 0,
  roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false } });
const transform = (child, x) => ({
  header: header(0, "link"), child_frame_id: child,
  transform: { translation: { x, y: 0, z: 0 }, rotation: { x: 0, y: 0, z: 0, w: 1 } } });

async function write(path, compression) {
  const parts = [];
  let size = 0n;
  const writable = {
    position: () => size,
    write: async (bytes) => { parts.push(new Uint8Array(bytes)); size += BigInt(bytes.length); },
  };
  const pack = (data) => ({
    compression,
    compressedData: new Uint8Array(execFileSync(compression, ["-q", "-c"], { input: data })),
  });
  const writer = new McapWriter({ writable, compressChunk: compression ? pack : undefined });
  await writer.start({ profile: "ros2", library: "" });
  const send = {};
  for (const [topic, type, text] of [
    ["/tf_static", "tf2_msgs/msg/TFMessage", TRANSFORMS],
    ["/camera/camera/color/image_raw", "sensor_msgs/msg/Image", IMAGE],
    ["/camera/camera/color/camera_info", "sensor_msgs/msg/CameraInfo", CAMERA_INFO],
    ["/camera/camera/depth/image_rect_raw", "sensor_msgs/msg/Image", IMAGE],
    ["/camera/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo", CAMERA_INFO]]) {
    const schemaId = await writer.registerSchema({ name: type, encoding: "ros2msg", data: new TextEncoder().encode(text) });
    const channelId = await writer.registerChannel({ schemaId, topic, messageEncoding: "cdr", metadata: new Map() });
    const serializer = new MessageWriter(parse(text, { ros2: true }));
    send[topic] = async (message, frame) => {
      const time = 1600000100000000000n + BigInt(frame) * 31250000n;
      await writer.addMessage({ channelId, sequence: frame, logTime: time, publishTime: time, data: serializer.writeMessage(message) });
    };
  }
  await send["/tf_static"]({ transforms: [transform("depth_frame", 0.01), transform("color_frame", 0.04)] }, 0);
  for (let i = 0; i < FRAMES; ++i) {
    await send["/camera/camera/color/image_raw"](image(i, "bgr8", 3 * WIDTH, color(i), "color_frame"), i);
    await send["/camera/camera/color/camera_info"](camera(i, 20, "color_frame"), i);
    await send["/camera/camera/depth/image_rect_raw"](image(i, "32FC1", 4 * WIDTH, depth(i), "depth_frame"), i);
    await send["/camera/camera/depth/camera_info"](camera(i, 18, "depth_frame"), i);
  }
  await writer.end();
  writeFileSync(path, Buffer.concat(parts));
}

const folder = process.argv[2];
await write(join(folder, "plain.mcap"), "");
await write(join(folder, "zstd.mcap"), "zstd");
await write(join(folder, "lz4.mcap"), "lz4");
