// Every reader of captures against files that are spoilt: cut at each tenth, overwritten, missing, out of order.
#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bake/analytic_field.h"
#include "clip/clip_io.h"
#include "formats/damage.h"
#include "host/frame_writer.h"
#include "host/interface_struct.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;
using Files = std::vector<std::string>;

constexpr int kFrames = 3;

const host::PluginTable& plugins() {
  static const host::PluginTable table = host::PluginTable::builtin();
  return table;
}

/// A still camera's frames in a format that can be written; times go up, or down.
void write_with(const char* format, const fs::path& path, double step) {
  auto info = host::make_struct<KinoraCaptureInfo>();
  info.frame_count = kFrames;
  info.frames_per_second = 10;
  info.camera = {kSampleWidth, kSampleHeight, 20, 20, 7.5, 5.5, {}, {}};
  info.has_poses = 1;
  host::FrameWriter writer(plugins().find(format), path, {}, info);
  for (int i = 0; i < kFrames; ++i) {
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
  for (int i = 0; i < kFrames; ++i) {
    folder.write("c" + std::to_string(i) + ".png", color_bytes(i));
    folder.write("d" + std::to_string(i) + ".png", depth_bytes(i));
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
  for (int i = 0; i < kFrames; ++i) {
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
  for (int i = 0; i < kFrames; ++i) {
    folder.write("in/c_" + std::to_string(i) + ".png", color_bytes(i));
    folder.write("in/d_" + std::to_string(i) + ".png", depth_bytes(i));
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
  for (int i = 0; i < kFrames; ++i) {
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
  return clip::write_clip(bake::testing::sample_clip(kFrames), folder.path() / "in" / "c.mkv"), true;
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

struct Reader {
  const char* format;
  bool (*make)(const TemporaryFolder& folder);
  const char* input;   ///< in the folder "in"; "": that folder
  Files spoilt;        ///< of "in"
  std::string removed; ///< of a capture in many files, one of its middle frame
};
std::ostream& operator<<(std::ostream& out, const Reader& reader) { return out << reader.format; }

const Reader kReaders[] = {
    {"tum-rgbd",
     make_tum,
     "",
     {"associations.txt", "groundtruth.txt", "intrinsics.json", "rgb/000000.png", "depth/000000.png"},
     "depth/000001.png"},
    {"numbered-folder",
     make_numbered,
     "",
     {"intrinsics.json", "color/000000.png", "depth/000000.png"},
     "depth/000001.png"},
    {"3dmatch",
     make_3dmatch,
     "",
     {"camera-intrinsics.txt", "frame-000000.color.png", "frame-000000.depth.png", "frame-000000.pose.txt"},
     "frame-000001.color.png"},
    {"m3t", make_m3t, "", {"color.yaml", "depth.yaml", "c_0.png", "d_0.png"}, "d_1.png"},
    {"transforms",
     make_transforms,
     "",
     {"transforms.json", "color/000000.png", "depth/000000.png"},
     "depth/000001.png"},
    {"exr-sequence", make_exr, "", {"intrinsics.json", "000000.exr"}, "000001.exr"},
    {"stray-scanner",
     make_stray,
     "",
     {"rgb.mp4", "odometry.csv", "camera_matrix.csv", "depth/000000.png"},
     "depth/000001.png"},
    {"video-pair", make_video_pair, "", {"color.mkv", "depth.mkv", "intrinsics.json"}, ""},
    {"azure-kinect", make_kinect, "r.mkv", {"r.mkv"}, ""},
    {"kinora-recording", make_recording, "r.mkv", {"r.mkv"}, ""},
    {"kinora-clip", make_clip, "c.mkv", {"c.mkv"}, ""},
    {"record3d", copy_sample<kR3d>, "sample.r3d", {"sample.r3d"}, ""},
    {"ros-bag", copy_sample<kBag>, "aligned_lz4.bag", {"aligned_lz4.bag"}, ""},
    {"ros-bag", copy_sample<kRealSense>, "librealsense.bag", {"librealsense.bag"}, ""},
    {"mcap", copy_sample<kMcap>, "plain.mcap", {"plain.mcap"}, ""},
    {"mcap", copy_sample<kZstdMcap>, "zstd.mcap", {"zstd.mcap"}, ""},
    {"oni", copy_sample<kOni>, "lossless.oni", {"lossless.oni"}, ""},
    {"oni", copy_sample<kJpegOni>, "jpeg.oni", {"jpeg.oni"}, ""},
    {"gltf-scene", copy_sample<kGlb>, "scene.glb", {"scene.glb"}, ""}};

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class BadInput : public testing::TestWithParam<Reader> {
protected:
  void SetUp() override {
    fs::create_directories(in());
    if (!GetParam().make(folder_)) GTEST_SKIP() << "ffmpeg is not installed";
    frames_ = read_capture(input(), GetParam().format).frames.size();
    ASSERT_GT(frames_, 0U);
  }
  fs::path in() const { return folder_.path() / "in"; }
  fs::path input() const { return *GetParam().input == '\0' ? in() : in() / GetParam().input; }

  /// Refused in one sentence that names it, or read as far as it goes, in order of time.
  void expect_borne(const std::string& what) {
    try {
      const CopiedCapture capture = read_capture(input(), GetParam().format);
      EXPECT_LE(capture.frames.size(), frames_ + 1) << what;
      double last = -std::numeric_limits<double>::infinity();
      for (const CopiedFrame& frame : capture.frames) {
        if (!frame.problem.empty()) continue;
        EXPECT_FALSE(frame.depth.empty()) << what;
        EXPECT_GE(frame.time, last) << what;
        last = frame.time;
      }
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::kCorruptInput || error.code() == ErrorCode::kNotRecognised)
          << what << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  void spoil(const std::string& file, const std::string& bytes) const {
    std::ofstream(in() / file, std::ios::binary | std::ios::trunc) << bytes;
  }

  TemporaryFolder folder_;
  std::size_t frames_ = 0;
};

TEST_P(BadInput, IsBorneWhenCutAtEachTenth) {
  for (const std::string& file : GetParam().spoilt)
    expect_bears_truncation(in() / file, input(), GetParam().format, frames_);
}

TEST_P(BadInput, AnotherMagicIsNotTakenForAWholeFile) {
  for (const std::string& file : GetParam().spoilt) {
    const std::string whole = contents(in() / file);
    std::string bytes = whole;
    std::fill_n(bytes.begin(), std::min<std::size_t>(bytes.size(), 16), 'X');
    spoil(file, bytes);
    expect_borne(file);
    if (in() / file == input() && in() / file != in() / "sample.r3d") { // a ZIP archive is told by its end
      EXPECT_THROW((void)read_capture(input()), Error) << "nobody takes it for a capture";
    }
    spoil(file, whole);
  }
}

/// Wherever a size may stand, it is absurd once.
TEST_P(BadInput, AbsurdSizesAreBorne) {
  constexpr std::size_t kPlaces = 32;
  for (const std::string& file : GetParam().spoilt) {
    const std::string whole = contents(in() / file);
    for (std::size_t k = 0; k < kPlaces; ++k) {
      for (const char value : {'\xFF', '\x7F'}) {
        std::string bytes = whole;
        const std::size_t at = k < kPlaces / 2 ? 4 * k : whole.size() * k / kPlaces; // heads are thick with sizes
        for (std::size_t i = at; i < std::min(at + 4, bytes.size()); ++i) bytes[i] = value;
        spoil(file, bytes);
        expect_borne(file + " at " + std::to_string(at));
      }
    }
    spoil(file, whole);
  }
}

std::string name_of(const testing::TestParamInfo<Reader>& chosen) {
  std::string name = chosen.param.format + std::string("_") + std::to_string(chosen.index);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, BadInput, testing::ValuesIn(kReaders), name_of);

/// Of captures in many files.
class MissingFile : public BadInput {};

TEST_P(MissingFile, CostsItsOwnFrameAlone) {
  fs::remove(in() / GetParam().removed);
  const CopiedCapture capture = read_capture(input(), GetParam().format);
  const auto whole =
      std::ranges::count_if(capture.frames, [](const CopiedFrame& frame) { return frame.problem.empty(); });
  EXPECT_EQ(static_cast<std::size_t>(whole), frames_ - 1);
}

std::vector<Reader> readers_of_folders() {
  std::vector<Reader> readers(std::begin(kReaders), std::end(kReaders));
  std::erase_if(readers, [](const Reader& reader) { return reader.removed.empty(); });
  return readers;
}
INSTANTIATE_TEST_SUITE_P(All, MissingFile, testing::ValuesIn(readers_of_folders()), name_of);

TEST(BadInputTable, HasEveryReader) {
  for (const host::FormatEntry& entry : plugins().formats()) {
    if (!host::supports(*entry.format, KINORA_READS_FRAMES) || host::supports(*entry.format, KINORA_READS_DEVICE))
      continue;
    const bool there = std::ranges::any_of(
        kReaders, [&](const Reader& reader) { return std::string_view(reader.format) == entry.format->name; });
    EXPECT_TRUE(there) << entry.format->name;
  }
}

// ---- timestamps that run backwards

/// Frames that come back in order of time, each with its own depth; what was left out is said.
void expect_in_order(const fs::path& input, const char* format) {
  const CopiedCapture capture = read_capture(input, format);
  ASSERT_GE(capture.frames.size(), 1U);
  double last = -1e300;
  for (const CopiedFrame& frame : capture.frames) {
    EXPECT_EQ(frame.problem, "");
    EXPECT_GE(frame.time, last) << format;
    last = frame.time;
  }
  if (capture.frames.size() > 1) {
    ASSERT_FALSE(capture.warnings.empty()) << format;
    EXPECT_NE(capture.warnings.front().find("out of order"), std::string::npos) << capture.warnings.front();
  }
}

TEST(TimesThatRunBackwards, ArePutInOrderWithAWarning) {
  for (const char* format : {"transforms", "exr-sequence"}) {
    const TemporaryFolder folder;
    write_with(format, folder.path(), -0.1);
    expect_in_order(folder.path(), format);
  }
}

TEST(TimesThatRunBackwards, OfListsAndLogsToo) {
  const TemporaryFolder folder;
  write_with("tum-rgbd", folder.path() / "tum", 0.1);
  fs::remove(folder.path() / "tum/associations.txt");
  for (const char* list : {"rgb", "depth"})
    folder.write(std::string("tum/") + list + ".txt",
                 fmt::format("5.2 {0}/000000.png\n5.1 {0}/000001.png\n5 {0}/000002.png\n", list));
  expect_in_order(folder.path() / "tum", "tum-rgbd");

  // The sender's clock, 0.25 s and 0.3125 s after a second, changed over.
  std::string log = contents(fs::path(KINORA_FORMAT_SAMPLES) / kMcap);
  const auto number = [](std::uint32_t value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const std::string first = number(250'000'000), last = number(312'500'000);
  for (std::size_t i = 0; i + 4 <= log.size(); ++i) {
    if (log.compare(i, 4, first) == 0)
      log.replace(i, 4, last);
    else if (log.compare(i, 4, last) == 0)
      log.replace(i, 4, first);
  }
  folder.write("a.mcap", log);
  expect_in_order(folder.path() / "a.mcap", "mcap");
}

} // namespace
} // namespace kinora::formats
