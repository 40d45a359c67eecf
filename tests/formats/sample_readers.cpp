#include "formats/sample_readers.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <zip.h>

#include "bake/analytic_field.h"
#include "clip/clip_io.h"
#include "host/frame_writer.h"
#include "host/interface_struct.h"

namespace kinora::formats {

using namespace kinora::test;

const host::PluginTable& sample_plugins() {
  static const host::PluginTable table = host::PluginTable::builtin();
  return table;
}

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

namespace {

/// A still camera's frames in a format that can be written, all but `lost`; times go up, or down.
void write_with(const char* format, const fs::path& path, double step, int lost = -1) {
  auto info = host::make_struct<KinoraCaptureInfo>();
  info.frame_count = kSampleFrames;
  info.frames_per_second = 10;
  info.camera = {kSampleWidth, kSampleHeight, 20, 20, 7.5, 5.5, {}, {}};
  info.has_poses = 1;
  host::FrameWriter writer(sample_plugins().find(format), path, {}, info);
  for (int i = 0; i < kSampleFrames; ++i) {
    if (i == lost) continue;
    const ColorImage color = sample_color(kSampleWidth, kSampleHeight, 3, i);
    const DepthImage16 depth = sample_depth(kSampleWidth, kSampleHeight, static_cast<std::uint16_t>(1000 + i));
    auto frame = host::make_struct<KinoraFrame>();
    frame.index = i;
    frame.time = 5 + step * i;
    frame.depth_unit = 0.001;
    frame.color = {kSampleWidth, kSampleHeight, 3, KINORA_PIXEL_U8, 3 * kSampleWidth, color.data(), {}};
    frame.depth = {kSampleWidth, kSampleHeight, 1, KINORA_PIXEL_U16, 2 * kSampleWidth, depth.data(), {}};
    frame.has_pose = 1;
    for (int k = 0; k < 16; k += 5) frame.camera_to_world[k] = 1;
    (void)writer.write(frame); // what goes back in time may be left out already here
  }
  writer.finish();
}

bool run(const TemporaryFolder& folder, const std::string& command) {
  return std::system(("cd '" + folder.path().string() + "' && " + command).c_str()) == 0;
}

void make_pictures(const TemporaryFolder& folder) {
  for (int i = 0; i < kSampleFrames; ++i) {
    folder.write(fmt::format("c{}.png", i), color_bytes(i));
    folder.write(fmt::format("d{}.png", i), depth_bytes(i));
  }
}

constexpr const char* kYaml = "%YAML:1.2\nload_directory: \"./\"\nintrinsics:\n  f_u: 20\n  f_v: 21.5\n  pp_x: 7.5\n"
                              "  pp_y: 5.5\n  width: 16\n  height: 12\ncamera2world_pose: !!opencv-matrix\n  rows: 4\n"
                              "  cols: 4\n  dt: d\n  data: [1., 0, 0, 0,\n 0, 1., 0, 0,\n 0, 0, 1., 0,\n 0, 0, 0, 1.]\n"
                              "load_index: 0\nn_leading_zeros: 0\nimage_name_post: \"\"\n"
                              "load_image_type: \"png\"\nimage_name_pre: ";

/// How a capture of each format comes to be; false: a program for it is not installed.
bool make_tum(const TemporaryFolder& folder) { return write_with("tum-rgbd", folder.path() / "in", 0.1), true; }
bool make_numbered(const TemporaryFolder& folder) {
  return write_with("numbered-folder", folder.path() / "in", 0.1), true;
}
/// With the calibration and the poses of Open3D.
bool make_open3d(const TemporaryFolder& folder) {
  write_with("numbered-folder", folder.path() / "in", 0.1);
  folder.remove("in/intrinsics.json");
  folder.write("in/intrinsic.json",
               R"({"width": 16, "height": 12, "intrinsic_matrix": [20, 0, 0, 0, 20, 0, 7.5, 5.5, 1]})");
  std::string poses;
  for (int i = 0; i < kSampleFrames; ++i)
    poses += fmt::format("{} {} {}\n1 0 0 0.5\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", i, i, i + 1);
  folder.write("in/trajectory.log", poses);
  return true;
}
bool make_transforms(const TemporaryFolder& folder) {
  return write_with("transforms", folder.path() / "in", 0.1), true;
}
bool make_exr(const TemporaryFolder& folder) {
  fs::create_directories(folder.path() / "in");
  return write_with("exr-sequence", folder.path() / "in", 0.1), true;
}
bool make_recording(const TemporaryFolder& folder) {
  fs::create_directories(folder.path() / "in");
  return write_with("kinora-recording", folder.path() / "in" / "r.mkv", 0.1), true;
}
bool make_3dmatch(const TemporaryFolder& folder) {
  folder.write("in/camera-intrinsics.txt", "20 0 7.5\n0 20 5.5\n0 0 1\n");
  for (int i = 0; i < kSampleFrames; ++i) {
    const std::string stem = "in/frame-" + six_digits(i);
    folder.write(stem + ".color.png", color_bytes(i));
    folder.write(stem + ".depth.png", depth_bytes(i));
    folder.write(stem + ".pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  }
  return true;
}
/// Of the two cameras, the one that has a scale is of depth.
bool make_m3t(const TemporaryFolder& folder) {
  folder.write("in/color.yaml", std::string(kYaml) + "\"c_\"\n");
  folder.write("in/depth.yaml", std::string(kYaml) + "\"d_\"\ndepth_scale: 0.001\n");
  for (int i = 0; i < kSampleFrames; ++i) {
    folder.write(fmt::format("in/c_{}.png", i), color_bytes(i));
    folder.write(fmt::format("in/d_{}.png", i), depth_bytes(i));
  }
  return true;
}
bool make_video_pair(const TemporaryFolder& folder) {
  make_pictures(folder);
  folder.write("in/intrinsics.json", kSampleIntrinsics);
  return run(folder, "ffmpeg -v error -y -framerate 25 -i c%d.png -c:v ffv1 -pix_fmt bgr0 in/color.mkv && "
                     "ffmpeg -v error -y -framerate 25 -i d%d.png -c:v ffv1 -pix_fmt gray16le in/depth.mkv");
}
bool make_stray(const TemporaryFolder& folder) {
  make_pictures(folder);
  std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  for (int i = 0; i < kSampleFrames; ++i) {
    odometry += std::to_string(50 + i) + ", " + six_digits(i) + ", 0, 0, 0, 0, 0, 0, 1\n";
    folder.write("in/depth/" + six_digits(i) + ".png", depth_bytes(i));
  }
  folder.write("in/odometry.csv", odometry);
  folder.write("in/camera_matrix.csv", "20,0,7.5\n0,20,5.5\n0,0,1\n");
  return run(folder, "ffmpeg -v error -y -framerate 25 -i c%d.png -pix_fmt yuv420p in/rgb.mp4");
}
bool make_kinect(const TemporaryFolder& folder) {
  const auto camera = [](const char* place) {
    return std::string(R"({"Location": "CALIBRATION_CameraLocation)") + place +
           R"(", "MetricRadius": 1.7, "Intrinsics": {"ModelParameters":
           [0.5, 0.5, 0.49, 0.49, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]}, "Rt": {"Rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1],
           "Translation": [0, 0, 0]}})";
  };
  folder.write("in/calibration.json",
               R"({"CalibrationInformation": {"Cameras": [)" + camera("D0") + ", " + camera("PV0") + "]}}");
  return run(folder, "cd in && ffmpeg -v error -y -f lavfi -i testsrc=s=1280x720:r=30 -f lavfi -i "
                     "color=black:s=320x288:r=30,format=gray16le,geq=lum=1000 -map 0 -map 1 -t 0.1 -c:v:0 mjpeg "
                     "-pix_fmt:v:0 yuvj420p -c:v:1 ffv1 -metadata:s:v:0 title=COLOR -metadata:s:v:1 title=DEPTH "
                     "-attach calibration.json -metadata:s:t mimetype=application/octet-stream -metadata "
                     "K4A_DEPTH_MODE=NFOV_2X2BINNED r.mkv && rm calibration.json");
}
bool make_clip(const TemporaryFolder& folder) {
  fs::create_directories(folder.path() / "in");
  return clip::write_clip(bake::testing::sample_clip(kSampleFrames), folder.path() / "in" / "c.mkv"), true;
}
template <const char* const& file> bool copy_sample(const TemporaryFolder& folder) {
  fs::create_directories(folder.path() / "in");
  fs::copy_file(fs::path(KINORA_FORMAT_SAMPLES) / file, folder.path() / "in" / fs::path(file).filename());
  return true;
}
constexpr const char* kBag = "ros_samples/aligned_lz4.bag";
constexpr const char* kRealSense = "ros_samples/librealsense.bag";
constexpr const char* kMcap = "ros_samples/plain.mcap";
constexpr const char* kZstdMcap = "ros_samples/zstd.mcap";
constexpr const char* kOni = "oni_samples/lossless.oni";
constexpr const char* kJpegOni = "oni_samples/jpeg.oni";
constexpr const char* kR3d = "record3d_samples/sample.r3d";
constexpr const char* kGlb = "blender_samples/scene.glb";

// ---- times that run backwards

template <const char* const& format> bool write_backwards(const TemporaryFolder& folder) {
  fs::remove_all(folder.path() / "in");
  const bool is_recording = std::string_view(format) == "kinora-recording";
  if (is_recording || std::string_view(format) == "exr-sequence") fs::create_directories(folder.path() / "in");
  return write_with(format, is_recording ? folder.path() / "in" / "r.mkv" : folder.path() / "in", -0.1), true;
}
constexpr const char* kTransforms = "transforms";
constexpr const char* kExr = "exr-sequence";
constexpr const char* kRecording = "kinora-recording";

bool turn_tum_back(const TemporaryFolder& folder) {
  folder.remove("in/associations.txt");
  for (const char* list : {"rgb", "depth"})
    folder.write(fmt::format("in/{}.txt", list),
                 fmt::format("5.2 {0}/000000.png\n5.1 {0}/000001.png\n5 {0}/000002.png\n", list));
  return true;
}
bool turn_stray_back(const TemporaryFolder& folder) {
  std::string odometry;
  for (int i = 0; i < kSampleFrames; ++i) odometry += fmt::format("{}, {}, 0, 0, 0, 0, 0, 0, 1\n", 50 - i, i);
  folder.write("in/odometry.csv", odometry);
  return true;
}

/// The packets of each video stay where they are, and are shown in the opposite order.
bool turn_videos_back(const TemporaryFolder& folder) {
  return run(folder, "for file in in/*.mkv; do ffmpeg -v error -y -i $file -map 0 -c copy -bsf:v "
                     "\"setts=pts=(2-N)*40:dts=N-10\" -avoid_negative_ts disabled turned.mkv && "
                     "mv turned.mkv $file || exit 1; done");
}

/// As above, in QuickTime: FFmpeg's Matroska keeps no order of showing for the video that is decoded here.
bool turn_pair_back(const TemporaryFolder& folder) {
  return run(folder, "for name in color depth; do ffmpeg -v error -y -i in/$name.mkv -c copy -bsf:v "
                     "\"setts=pts=(2-N)*40:dts=N-10\" -video_track_timescale 1000 -use_editlist 0 in/$name.mov && "
                     "rm in/$name.mkv || exit 1; done");
}

/// Puts the numbers at these places in the opposite order.
template <class Number> void reverse_numbers(std::string& bytes, const std::vector<std::size_t>& places) {
  for (std::size_t i = 0, j = places.size(); i + 1 < j--; ++i)
    std::swap_ranges(bytes.begin() + static_cast<std::ptrdiff_t>(places[i]),
                     bytes.begin() + static_cast<std::ptrdiff_t>(places[i] + sizeof(Number)),
                     bytes.begin() + static_cast<std::ptrdiff_t>(places[j]));
}
template <class Number> Number number_at(const std::string& bytes, std::size_t place) {
  Number number{};
  std::memcpy(&number, bytes.data() + place, sizeof number);
  return number;
}

/// Of a log that is not packed: the sender's clock, 0.25 s and 0.3125 s after a second, changed over.
template <const char* const& file> bool turn_log_back(const TemporaryFolder& folder) {
  const fs::path name = fs::path("in") / fs::path(file).filename();
  std::string log = contents(folder.path() / name);
  for (std::size_t i = 0; i + 4 <= log.size(); ++i) {
    constexpr std::uint32_t kFirst = 250'000'000, kLast = 312'500'000;
    const auto number = number_at<std::uint32_t>(log, i);
    if (number != kFirst && number != kLast) continue;
    const std::uint32_t other = number == kFirst ? kLast : kFirst;
    std::memcpy(log.data() + i, &other, sizeof other);
  }
  folder.write(name, log);
  return true;
}

constexpr std::size_t kOniRecordHeadBytes = 28;

/// Where the records of the pictures of each stream of OpenNI's file begin.
std::map<std::uint32_t, std::vector<std::size_t>> oni_pictures(const std::string& bytes) {
  constexpr std::uint32_t kNewData = 0x0A, kEnd = 0x0B;
  constexpr std::size_t kFileHeadBytes = 24;
  std::map<std::uint32_t, std::vector<std::size_t>> records;
  for (std::size_t at = kFileHeadBytes; at + kOniRecordHeadBytes <= bytes.size();) {
    const auto type = number_at<std::uint32_t>(bytes, at + 4);
    if (type == kEnd) break;
    if (type == kNewData) records[number_at<std::uint32_t>(bytes, at + 8)].push_back(at);
    at += std::size_t{number_at<std::uint32_t>(bytes, at + 12)} + number_at<std::uint32_t>(bytes, at + 16);
  }
  return records;
}

template <const char* const& file> bool turn_oni_back(const TemporaryFolder& folder) {
  const fs::path name = fs::path("in") / fs::path(file).filename();
  std::string bytes = contents(folder.path() / name);
  auto pictures = oni_pictures(bytes);
  for (auto& [stream, places] : pictures) {
    for (std::size_t& place : places) place += kOniRecordHeadBytes; // of the time
    reverse_numbers<std::uint64_t>(bytes, places);
  }
  folder.write(name, bytes);
  return !pictures.empty();
}

bool turn_r3d_back(const TemporaryFolder& folder) {
  zip_t* const archive = zip_open((folder.path() / "in/sample.r3d").c_str(), 0, nullptr);
  const std::string metadata = R"({"w": 128, "h": 96, "dw": 64, "dh": 48, "fps": 60,
    "K": [100, 0, 0, 0, 101, 0, 63.5, 47.5, 1], "frameTimestamps": [10.2, 10.1, 10]})";
  const bool added = zip_file_add(archive, "metadata", zip_source_buffer(archive, metadata.data(), metadata.size(), 0),
                                  ZIP_FL_OVERWRITE) >= 0;
  return zip_close(archive) == 0 && added;
}

/// The times of the first keys of each animation.
bool turn_glb_back(const TemporaryFolder& folder) {
  std::string bytes = contents(folder.path() / "in/scene.glb");
  constexpr std::size_t kJson = 20, kChunkHead = 8;
  const std::size_t json_bytes = number_at<std::uint32_t>(bytes, 12);
  const auto json = nlohmann::json::parse(bytes.substr(kJson, json_bytes));
  std::set<int> inputs;
  for (const auto& animation : json["animations"])
    for (const auto& sampler : animation["samplers"]) inputs.insert(sampler["input"].get<int>());
  for (const int input : inputs) {
    const auto& accessor = json["accessors"][static_cast<std::size_t>(input)];
    const auto& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    const std::size_t at = kJson + json_bytes + kChunkHead + view.value("byteOffset", std::size_t{0}) +
                           accessor.value("byteOffset", std::size_t{0});
    reverse_numbers<float>(bytes, {at, at + sizeof(float)});
  }
  folder.write("in/scene.glb", bytes);
  return !inputs.empty();
}

// ---- a frame that is missing

bool lose_of_recording(const TemporaryFolder& folder) {
  return write_with(kRecording, folder.path() / "in" / "r.mkv", 0.1, 1), true;
}

/// The second packet of every video.
bool lose_of_videos(const TemporaryFolder& folder) {
  return run(folder, "for file in in/*.mkv; do ffmpeg -v error -y -i $file -map 0 -c copy -bsf:v "
                     "\"noise=drop='eq(n,1)'\" less.mkv && mv less.mkv $file || exit 1; done");
}

/// Of a log that is not packed, what was sent at 0.28125 s after a second: its records become ones that nobody knows.
template <const char* const& file> bool lose_of_log(const TemporaryFolder& folder) {
  constexpr std::uint32_t kMiddle = 281'250'000;
  constexpr char kUnknown = 0x70;
  constexpr std::size_t kMcapKindToTime = 39; // of a message of ROS 2
  const fs::path name = fs::path("in") / fs::path(file).filename();
  std::string log = contents(folder.path() / name);
  int lost = 0;
  for (std::size_t i = kMcapKindToTime; i + 4 <= log.size(); ++i) {
    if (number_at<std::uint32_t>(log, i) != kMiddle) continue;
    const bool is_bag = name.extension() == ".bag";
    const std::size_t kind = is_bag ? log.rfind("op=\x02", i) + 3 : i - kMcapKindToTime;
    if (!is_bag && log[kind] != 5) continue; // no message: another of its times
    log[kind] = kUnknown;
    ++lost;
  }
  folder.write(name, log);
  return lost > 0;
}

/// Of each stream the middle picture's record becomes one that nobody knows.
template <const char* const& file> bool lose_of_oni(const TemporaryFolder& folder) {
  const fs::path name = fs::path("in") / fs::path(file).filename();
  std::string bytes = contents(folder.path() / name);
  const auto pictures = oni_pictures(bytes);
  for (const auto& [stream, places] : pictures) bytes[places[places.size() / 2] + 4] = 0x70;
  folder.write(name, bytes);
  return !pictures.empty();
}

bool lose_of_r3d(const TemporaryFolder& folder) {
  zip_t* const archive = zip_open((folder.path() / "in/sample.r3d").c_str(), 0, nullptr);
  const zip_int64_t depth = zip_name_locate(archive, "rgbd/1.depth", 0);
  const bool lost = depth >= 0 && zip_delete(archive, static_cast<zip_uint64_t>(depth)) == 0;
  return zip_close(archive) == 0 && lost;
}

} // namespace

const std::vector<SampleReader>& sample_readers() {
  static const std::vector<SampleReader> readers = {
      {"tum-rgbd",
       make_tum,
       "",
       {"associations.txt", "groundtruth.txt", "intrinsics.json", "rgb/000000.png", "depth/000000.png"},
       "depth/000001.png",
       turn_tum_back},
      {"numbered-folder",
       make_numbered,
       "",
       {"intrinsics.json", "color/000000.png", "depth/000000.png"},
       "depth/000001.png",
       nullptr},
      {"numbered-folder", make_open3d, "", {"intrinsic.json", "trajectory.log"}, "color/000001.png", nullptr},
      {"3dmatch",
       make_3dmatch,
       "",
       {"camera-intrinsics.txt", "frame-000000.color.png", "frame-000000.depth.png", "frame-000000.pose.txt"},
       "frame-000001.color.png",
       nullptr},
      {"m3t", make_m3t, "", {"color.yaml", "depth.yaml", "c_0.png", "d_0.png"}, "d_1.png", nullptr},
      {"transforms",
       make_transforms,
       "",
       {"transforms.json", "color/000000.png", "depth/000000.png"},
       "depth/000001.png",
       write_backwards<kTransforms>},
      {"exr-sequence", make_exr, "", {"intrinsics.json", "000000.exr"}, "000001.exr", write_backwards<kExr>},
      {"stray-scanner",
       make_stray,
       "",
       {"rgb.mp4", "odometry.csv", "camera_matrix.csv", "depth/000000.png"},
       "depth/000001.png",
       turn_stray_back},
      {"video-pair",
       make_video_pair,
       "",
       {"color.mkv", "depth.mkv", "intrinsics.json"},
       "",
       turn_pair_back,
       lose_of_videos},
      {"azure-kinect", make_kinect, "r.mkv", {"r.mkv"}, "", turn_videos_back, lose_of_videos},
      {"kinora-recording", make_recording, "r.mkv", {"r.mkv"}, "", write_backwards<kRecording>, lose_of_recording},
      {"kinora-clip", make_clip, "c.mkv", {"c.mkv"}, "", nullptr},
      {"record3d", copy_sample<kR3d>, "sample.r3d", {"sample.r3d"}, "", turn_r3d_back, lose_of_r3d},
      {"ros-bag", copy_sample<kBag>, "aligned_lz4.bag", {"aligned_lz4.bag"}, "", nullptr},
      {"ros-bag",
       copy_sample<kRealSense>,
       "librealsense.bag",
       {"librealsense.bag"},
       "",
       turn_log_back<kRealSense>,
       lose_of_log<kRealSense>},
      {"mcap", copy_sample<kMcap>, "plain.mcap", {"plain.mcap"}, "", turn_log_back<kMcap>, lose_of_log<kMcap>},
      {"mcap", copy_sample<kZstdMcap>, "zstd.mcap", {"zstd.mcap"}, "", nullptr},
      {"oni", copy_sample<kOni>, "lossless.oni", {"lossless.oni"}, "", turn_oni_back<kOni>, lose_of_oni<kOni>},
      {"oni", copy_sample<kJpegOni>, "jpeg.oni", {"jpeg.oni"}, "", turn_oni_back<kJpegOni>, lose_of_oni<kJpegOni>},
      {"gltf-scene", copy_sample<kGlb>, "scene.glb", {"scene.glb"}, "", turn_glb_back}};
  return readers;
}

std::ostream& operator<<(std::ostream& out, const SampleReader& reader) { return out << reader.format; }

std::string name_of(const testing::TestParamInfo<SampleReader>& chosen) {
  std::string name = fmt::format("{}_{}", chosen.param.format, chosen.index);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

} // namespace kinora::formats
