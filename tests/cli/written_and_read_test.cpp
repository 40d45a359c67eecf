// What is made of a clip, read again by Kinora's own readers and compared with the clip, as a user does it.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>

#include <nlohmann/json.hpp>

#include "bake/analytic_field.h"
#include "cli/known_formats.h"
#include "cli/run_kinora.h"
#include "clip/clip_io.h"
#include "core/error.h"
#include "formats/capture_frames.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

constexpr int kFrames = 3;
constexpr int kWidth = 256;
constexpr int kHeight = 192;
constexpr double kClipRate = 10;

/// Large enough for the rims of things, which pictures draw soft and meshes cut, to be few of their pixels.
clip::Clip sample() {
  clip::Clip clip = bake::testing::sample_clip(kFrames);
  clip.intrinsics = clip.intrinsics.resized(kWidth, kHeight);
  return clip;
}

/// Writes a file anew with something that its reader needs and an export does not have.
using Complete = void (*)(const fs::path& file);

/// How far a reading may be from what is drawn of the clip. The sample's things are soft: their shells are two cells of
/// 2 cm thick, and a mesh is at the outer one.
struct Tolerance {
  double depth = 0;          ///< metres
  double depth_outliers = 0; ///< share of the pixels that show something in which depth may be elsewhere, or nothing
  int color = 0;             ///< codes of sRGB
  double color_outliers = 0; ///< share of those pixels; pictures in linear light mix what is half transparent otherwise
  bool labels = false;       ///< whether labels are those of the clip's layers; else what moves has one, and no other
  bool pose = false;         ///< whether the camera's pose is kept
};

/// A format that a clip is written in, and the one that reads it; "" where none does.
struct Trip {
  std::string writer;
  std::string reader;
  std::string command;
  std::string output;
  std::vector<std::string> options;
  host::Options reading;
  Complete complete;
  Tolerance tolerance;
};

/// A camera where the capture's stood, for a file has none: glTF's axes, y up, z back.
void add_camera(const fs::path& file) {
  const std::string bytes = contents_of(file);
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  Json gltf = Json::parse(bytes.substr(20, length));
  const clip::Clip clip = sample();
  const Eigen::Vector3d& at = clip.camera_to_world[0].translation();
  gltf["cameras"] = {
      {{"type", "perspective"},
       {"perspective", {{"yfov", 2 * std::atan(clip.intrinsics.height / (2 * clip.intrinsics.fy))}, {"znear", 0.01}}}}};
  gltf["scenes"][0]["nodes"].push_back(gltf["nodes"].size());
  gltf["nodes"].push_back({{"camera", 0}, {"translation", {at.x(), -at.y(), -at.z()}}});
  std::string text = gltf.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string out = bytes.substr(0, 8);
  const auto number = [&out](std::size_t value) {
    const auto v = static_cast<std::uint32_t>(value);
    out.append(reinterpret_cast<const char*>(&v), 4);
  };
  number(20 + text.size() + bytes.size() - 20 - length);
  number(text.size());
  out += bytes.substr(16, 4) + text + bytes.substr(20 + length);
  std::ofstream(file, std::ios::binary) << out;
}

const Trip kTrips[] = {
    {"glb",
     "gltf-scene",
     "convert",
     "a.glb",
     {},
     {{"width", "256"}, {"height", "192"}, {"fps", "10"}},
     add_camera,
     {0.04, 0.15, 24, 0.15, false, false}},
    {"data-set", "transforms", "render", "set", {"-O", "format=data-set"}, {}, nullptr, {0.00051, 0, 1, 0, true, true}},
    {"exr", "exr-sequence", "render", "exr", {"-O", "format=exr"}, {}, nullptr, {0.0002, 0, 1, 0.15, true, true}},
    {"png", "", "render", "png", {"--passes", "rgb,depth"}, {}, nullptr, {}},
    {"mp4", "", "render", "a.mp4", {}, {}, nullptr, {}},
    {"usd", "", "convert", "a.usda", {}, {}, nullptr, {}},
    {"ply", "", "convert", "a.ply", {}, {}, nullptr, {}},
    {"obj", "", "convert", "a.obj", {}, {}, nullptr, {}},
    {"openvdb", "", "convert", "a.vdb", {"-O", "voxel=0.05"}, {}, nullptr, {}}};

class WrittenAndRead : public testing::Test {
protected:
  WrittenAndRead() { clip::write_clip(sample(), clip()); }
  fs::path clip() const { return folder_.path() / "clip.mkv"; }
  fs::path path(const std::string& name) const { return folder_.path() / name; }
  void write(const Trip& trip) const {
    std::vector<std::string> words{trip.command, clip().string(), path(trip.output).string()};
    words.insert(words.end(), trip.options.begin(), trip.options.end());
    const Said said = run_kinora(folder_, words);
    ASSERT_EQ(said.code, 0) << said.err;
    if (trip.complete != nullptr) trip.complete(path(trip.output));
  }
  /// The file that came of it, or the folder.
  fs::path written(const Trip& trip) const {
    if (fs::exists(path(trip.output))) return path(trip.output);
    const fs::path name = trip.output;
    return path(name.stem().string() + "_0001" + name.extension().string());
  }

  TemporaryFolder folder_;
};

std::uint16_t depth_at(const CopiedFrame& frame, std::size_t pixel) {
  std::uint16_t depth = 0;
  std::memcpy(&depth, frame.depth.data() + 2 * pixel, 2);
  return depth;
}

/// Whether the pixel and all beside it show something.
bool is_inside(const CopiedFrame& frame, std::size_t pixel) {
  const int u = static_cast<int>(pixel) % kWidth;
  const int v = static_cast<int>(pixel) / kWidth;
  for (int y = v - 1; y <= v + 1; ++y)
    for (int x = u - 1; x <= u + 1; ++x)
      if (x < 0 || y < 0 || x >= kWidth || y >= kHeight ||
          depth_at(frame, static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)) == 0)
        return false;
  return true;
}

void expect_same_frame(const CopiedFrame& truth, const CopiedFrame& made, const Tolerance& allowed) {
  ASSERT_EQ(made.problem, "");
  ASSERT_EQ(made.depth.size(), truth.depth.size());
  const std::size_t pixels = truth.depth.size() / 2;
  std::size_t shown = 0;
  std::size_t off_depth = 0;
  std::size_t off_color = 0;
  std::size_t off_label = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const double z = depth_at(truth, i) * truth.depth_unit;
    const double z_made = depth_at(made, i) * made.depth_unit;
    shown += z > 0 || z_made > 0 ? 1 : 0;
    off_depth += std::abs(z - z_made) > allowed.depth ? 1 : 0;
    if (!is_inside(truth, i) || z_made == 0) continue;
    int color = 0;
    for (std::size_t c = 3 * i; c < 3 * i + 3; ++c)
      color = std::max(color, std::abs(std::to_integer<int>(truth.color[c]) - std::to_integer<int>(made.color[c])));
    off_color += color > allowed.color ? 1 : 0;
    const bool is_label = truth.labels[i] != std::byte{};
    const bool same = allowed.labels ? truth.labels[i] == made.labels[i] : is_label == (made.labels[i] != std::byte{});
    off_label += same ? 0 : 1;
  }
  EXPECT_GT(shown, pixels / 40) << "something is seen";
  const auto limit = [shown](double share) { return static_cast<std::size_t>(share * static_cast<double>(shown)); };
  EXPECT_LE(off_depth, limit(allowed.depth_outliers)) << "of " << shown;
  EXPECT_LE(off_color, limit(allowed.color_outliers)) << "of " << shown;
  EXPECT_EQ(off_label, 0U) << "of " << shown;
}

TEST_F(WrittenAndRead, ItIsWhatTheClipShows) {
  const CopiedCapture truth = read_capture(clip());
  ASSERT_EQ(truth.format, "kinora-clip");
  const clip::Clip shown = sample();
  for (const Trip& trip : kTrips) {
    if (trip.reader.empty()) continue;
    SCOPED_TRACE(trip.writer + " read as " + trip.reader);
    write(trip);
    const CopiedCapture made = read_capture(written(trip), "", trip.reading);
    EXPECT_EQ(made.format, trip.reader);
    EXPECT_NEAR(made.info.camera.fx, truth.info.camera.fx, 1e-6);
    EXPECT_NEAR(made.info.camera.cy, truth.info.camera.cy, 1e-6);
    EXPECT_NEAR(made.info.frames_per_second, kClipRate, 1e-6);
    ASSERT_EQ(made.frames.size(), truth.frames.size());
    for (std::size_t i = 0; i < truth.frames.size(); ++i) {
      SCOPED_TRACE("frame " + std::to_string(i));
      expect_same_frame(truth.frames[i], made.frames[i], trip.tolerance);
      EXPECT_NEAR(made.frames[i].time - made.frames[0].time, truth.frames[i].time - truth.frames[0].time, 1e-6);
      if (!trip.tolerance.pose) continue;
      const Eigen::Matrix4d pose = shown.capture_camera(static_cast<double>(i)).camera_to_world.matrix();
      for (int k = 0; k < 16; ++k)
        EXPECT_NEAR(made.frames[i].pose[static_cast<std::size_t>(k)], pose(k / 4, k % 4), 1e-6);
    }
  }
}

TEST_F(WrittenAndRead, NothingIsReadThatIsNotCompared) {
  const host::PluginTable plugins = host::PluginTable::builtin();
  for (const Trip& trip : kTrips) {
    if (!trip.reader.empty()) continue;
    write(trip);
    try {
      const KinoraFormat& reader = plugins.recognise(written(trip));
      ADD_FAILURE() << trip.writer << " is read as " << reader.name << ": compare it here";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kNotRecognised) << trip.writer << ": " << error.what();
    }
  }
}

/// Formats that read and write captures under one name are compared in capture_conversion_test.
TEST_F(WrittenAndRead, EveryFormatThatIsMadeOfAClipIsTried) {
  std::set<std::string> tried;
  for (const Trip& trip : kTrips) tried.insert(trip.writer);
  EXPECT_EQ(tried, export_formats(folder_));
}

} // namespace
} // namespace kinora::test
