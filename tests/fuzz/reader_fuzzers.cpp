// Captures in one file, or of which one file is the input.
#include "core/error.h"
#include "formats/sample_capture.h"
#include "fuzz/fuzzer.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "record/sample_recording.h"
#include "ros/rvl.h"

namespace kinora::fuzz {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;

constexpr int kMaxFrames = 3;

Bytes contents_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return bytes_of({std::istreambuf_iterator<char>(file), {}});
}

void read_capture(const fs::path& path, const std::string& format, const host::Options& options = {}) {
  static const host::PluginTable plugins = host::PluginTable::builtin();
  ingest::CaptureOptions how;
  how.format = format;
  how.format_options = options;
  how.frames.end = kMaxFrames;
  Progress progress;
  const auto capture = ingest::Capture::open(plugins, path, how, progress);
  while (capture->next()) {
  }
}

// ---- OpenEXR: one of two frames

void read_exr(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("intrinsics.json", R"({"fx": 60, "fy": 60, "cx": 31.5, "cy": 23.5})");
  folder.write("1.exr", contents_of(fs::path(KINORA_BLENDER_SAMPLES) / "render/0000.exr"));
  folder.write("2.exr", input);
  read_capture(folder.path(), "exr-sequence");
}
std::vector<Bytes> exrs() {
  std::vector<Bytes> seeds;
  for (const char* name : {"render/0002.exr", "render/0004.exr"})
    seeds.push_back(contents_of(fs::path(KINORA_BLENDER_SAMPLES) / name));
  return seeds;
}

// ---- glTF

void read_gltf(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  const bool binary = input.size() > 4 && std::memcmp(input.data(), "glTF", 4) == 0;
  const std::string name = binary ? "a.glb" : "a.gltf";
  folder.write(name, input);
  read_capture(folder.path() / name, "gltf-scene", {{"width", "16"}, {"height", "12"}});
}
constexpr const char* kGltf = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
"nodes": [{"mesh": 0, "translation": [0, 0, -3], "name": "a"}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5}], "weights": [0.5]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "sparse": {"count": 1,
"indices": {"bufferView": 0, "componentType": 5121, "byteOffset": 0}, "values": {"bufferView": 0, "byteOffset": 0}}}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36,
"uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
std::vector<Bytes> gltfs() { return {contents_of(fs::path(KINORA_BLENDER_SAMPLES) / "scene.glb"), bytes_of(kGltf)}; }

// ---- recordings

void read_recording(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("a.mkv", input);
  read_capture(folder.path() / "a.mkv", "kinora-recording");
}
std::vector<Bytes> recordings() {
  const TemporaryFolder folder;
  std::optional<record::Recorder> recorder;
  for (int i = 0; i < kMaxFrames; ++i) {
    test::SampleFrame sample(i);
    for (int k = 0; k < 16; ++k) sample.frame.camera_to_world[k] = k % 5 == 0 ? 1 : 0;
    if (!recorder) recorder.emplace(folder.path() / "r.mkv", test::sample_description(), sample.frame);
    recorder->write(sample.frame);
  }
  recorder->finish();
  return {contents_of(folder.path() / "r.mkv")};
}

// ---- OpenNI

void read_oni(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("a.oni", input);
  read_capture(folder.path() / "a.oni", "oni");
}
std::vector<Bytes> onis() {
  const fs::path samples = KINORA_ONI_SAMPLES;
  return {contents_of(samples / "lossless.oni"), contents_of(samples / "jpeg.oni")};
}

// ---- videos, as FFmpeg wrote them

fs::path video_sample(const char* name) { return fs::path(KINORA_VIDEO_SAMPLES) / name; }

/// One of a pair: grey of 16 bits, or colours that mean depth.
void read_depth_video(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("color.mkv", contents_of(video_sample("color.mkv")));
  folder.write("intrinsics.json", R"({"fx": 30, "fy": 30, "cx": 15.5, "cy": 11.5})");
  folder.write("depth.mkv", input);
  read_capture(folder.path(), "video-pair");
}
std::vector<Bytes> depth_videos() {
  return {contents_of(video_sample("depth.mkv")), contents_of(video_sample("rgb.mp4"))};
}

void read_stray_video(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("odometry.csv", "timestamp, frame, x, y, z, qx, qy, qz, qw\n50.0, 000000, 0, 0, 0, 0, 0, 0.6, 0.8\n");
  folder.write("camera_matrix.csv", "30,0,15.5\n0,30,11.5\n0,0,1\n");
  folder.write("depth/000000.png", test::depth_bytes(0));
  folder.write("rgb.mp4", input);
  read_capture(folder.path(), "stray-scanner");
}
std::vector<Bytes> stray_videos() { return {contents_of(video_sample("rgb.mp4"))}; }

void read_kinect(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("a.mkv", input);
  read_capture(folder.path() / "a.mkv", "azure-kinect");
}
std::vector<Bytes> kinects() { return {contents_of(video_sample("kinect.mkv"))}; }

// ---- depth of ROS

void unpack_rvl(std::span<const std::byte> input) { (void)formats::unpack_rvl(input, "fuzz"); }
std::vector<Bytes> rvls() {
  const std::uint32_t words[] = {2, 2, 0x12A10100U};
  const auto bytes = std::as_bytes(std::span(words));
  return {{bytes.begin(), bytes.end()}, contents_of(fs::path(KINORA_ROS_SAMPLES) / "image_transport.rvl")};
}

} // namespace

std::vector<Fuzzer> reader_fuzzers() {
  return {{"depth_video", depth_videos, read_depth_video, 200},
          {"stray_video", stray_videos, read_stray_video, 200},
          {"azure_kinect", kinects, read_kinect, 30},
          {"exr", exrs, read_exr, 300},
          {"gltf", gltfs, read_gltf, 400},
          {"oni", onis, read_oni, 300},
          {"recording", recordings, read_recording, 100},
          {"rvl", rvls, unpack_rvl, 3000}};
}

} // namespace kinora::fuzz
