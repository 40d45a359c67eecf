// Follows the things of synthetic scenes (tests/tracking/scenes/thing_scenes.h) and compares them with their own truth.
// One line of CSV for each thing: error at its middle, of its rotation, of its axis y alone (about which a vase or a
// ball may turn unseen) and of the turn since the frame before (which tells where it may not) while a fifth of it at
// least is seen; frames seen, of these not tracked; the processor's time of a frame. Usage: bench_tracking_things
// [KNOB=VALUE,VALUE...] [FOLDER]; scene: by name; seed: of the noise; frames=1 also tells it frame by frame; with a
// folder, scenes are kept there as captures, and read if they are there already.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/image_codec.h"
#include "follow_label.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "knobs.h"
#include "stopwatch.h"
#include "tracking/rigid/rigid_tracker.h"
#include "tracking/scenes/thing_scenes.h"

namespace {

using namespace kinora;
using namespace kinora::tracking;
using kinora::motion::Health;
namespace fs = std::filesystem;

constexpr double kDegrees = 180 / std::numbers::pi;

struct Errors {
  std::vector<double> values;
  /// Mean and worst.
  std::string text() const {
    if (values.empty()) return ",";
    double sum = 0;
    for (const double value : values) sum += value;
    return fmt::format("{:.2f},{:.2f}", sum / static_cast<double>(values.size()),
                       *std::max_element(values.begin(), values.end()));
  }
};

struct Followed {
  explicit Followed(const testing::MovingThing& moving) : thing(&moving), tracker(moving.label) {}

  void follow(const ingest::Frame& frame, bool each) {
    const auto labels = frame.labels.values();
    const auto pixels = static_cast<double>(std::count(labels.begin(), labels.end(), thing->label));
    const bench::Stopwatch watch;
    const RigidTrackingResult result = tracker.track(frame);
    processor.push_back(watch.processor_milliseconds());
    max_pixels = std::max(max_pixels, pixels);
    const SE3 now = thing->pose(frame.index);
    if (!first && result.pose.health == Health::kTracked) first = before = before_found = now;
    if (!first) return;
    const SE3 found = result.pose.canonical_to_world * *first;
    const double distance = 1e3 * (found.translation() - now.translation()).norm();
    const double rotation = kDegrees * rotation_angle(found.inverse() * now);
    const double tilt = kDegrees * std::acos(std::clamp(found.linear().col(1).dot(now.linear().col(1)), -1.0, 1.0));
    const double axial_rotation =
        kDegrees * rotation_angle((before_found.inverse() * found).inverse() * (before.inverse() * now));
    before_found = found;
    before = now;
    if (each) {
      const PoseQuality& quality = result.quality;
      std::printf(
          "# frame %d label %d: %s, %.0f pixels, %.2f mm, %.2f degrees, axis %.2f, turn %.2f; weak %d, inliers %.2f, "
          "correlation %.2f, explained %.2f, outside %.2f, %.1f ms\n",
          frame.index, thing->label, std::string(name_of(result.pose.health)).c_str(), pixels, distance, rotation, tilt,
          axial_rotation, result.degenerate_directions, quality.inlier_share(), quality.texture_correlation,
          quality.explained_share, quality.free_space_share(), processor.back());
    }
    if (pixels < 0.2 * max_pixels) return;
    ++seen;
    not_tracked += result.pose.health == Health::kTracked ? 0 : 1;
    distances.values.push_back(distance);
    rotations.values.push_back(rotation);
    tilts.values.push_back(tilt);
    axial_rotations.values.push_back(axial_rotation);
  }

  const testing::MovingThing* thing;
  RigidTracker tracker;
  std::optional<SE3> first;
  SE3 before, before_found; ///< thing to world in the frame before: true and found
  Errors distances, rotations, tilts, axial_rotations;
  std::vector<double> processor;
  double max_pixels = 0;
  int seen = 0;
  int not_tracked = 0;
};

/// Of a scene, drawn, or read from its capture.
class Frames {
public:
  Frames(const testing::ThingScene& scene, const testing::ThingCamera& camera, const fs::path& capture)
      : scene_(&scene), camera_(camera) {
    if (!capture.empty()) capture_ = ingest::Capture::open(plugins_, capture, {}, silent_);
  }
  ingest::Frame next() {
    if (!capture_) return testing::see_things(*scene_, index_++, camera_);
    ingest::Frame frame = capture_->next().value();
    frame.camera.camera_to_world = scene_->camera(index_++);
    return frame;
  }

private:
  const testing::ThingScene* scene_;
  testing::ThingCamera camera_;
  int index_ = 0;
  Progress silent_;
  host::PluginTable plugins_ = host::PluginTable::builtin();
  std::unique_ptr<ingest::Capture> capture_;
};

void follow(const testing::ThingScene& scene, const bench::Setting& knobs, const testing::ThingCamera& camera,
            const fs::path& capture) {
  Frames frames(scene, camera, capture);
  std::vector<Followed> followed;
  for (const testing::MovingThing& thing : scene.things) {
    if (thing.label > 0) followed.emplace_back(thing);
  }
  for (int i = 0; i < scene.frames; ++i) {
    const ingest::Frame frame = frames.next();
    for (Followed& one : followed) one.follow(frame, knobs.at("frames") != 0);
  }
  for (const Followed& one : followed) {
    std::printf("%s,%d,%s,%s,%s,%s,%d,%d,%.1f,%.1f\n", std::string(scene.name).c_str(), one.thing->label,
                one.distances.text().c_str(), one.rotations.text().c_str(), one.tilts.text().c_str(),
                one.axial_rotations.text().c_str(), one.seen, one.not_tracked, bench::at_fraction(one.processor, 0.5),
                bench::at_fraction(one.processor, 0.95));
  }
  std::fflush(stdout);
}

void write_bytes(const fs::path& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

std::string row_of(int frame, const SE3& pose) {
  std::string row = fmt::format("{} {:.6f}", frame, 1000 + frame / 30.0);
  for (int i = 0; i < 16; ++i) row += fmt::format(" {:.8f}", pose.matrix()(i / 4, i % 4));
  return row + "\n";
}

// As captures of this kind lie in folders: rgb/, depth/, mask/, intrinsics.json and the truth in gt/.
void write_capture(const testing::ThingScene& scene, const testing::ThingCamera& camera, const fs::path& folder) {
  for (const char* part : {"rgb", "depth", "mask", "gt"}) fs::create_directories(folder / part);
  std::map<int, std::string> poses;
  std::string cameras;
  std::string associations;
  for (int i = 0; i < scene.frames; ++i) {
    const ingest::Frame frame = testing::see_things(scene, i, camera);
    const std::string name = fmt::format("{:06d}.png", i);
    write_bytes(folder / "rgb" / name, encode_png(frame.color));
    DepthImage16 depth(frame.depth.width(), frame.depth.height());
    for (std::size_t k = 0; k < depth.values().size(); ++k) {
      depth.values()[k] = static_cast<std::uint16_t>(std::lround(1e3F * frame.depth.values()[k]));
    }
    write_bytes(folder / "depth" / name, encode_png16(depth));
    ColorImage mask(frame.labels.width(), frame.labels.height(), 1);
    std::copy(frame.labels.values().begin(), frame.labels.values().end(), mask.values().begin());
    write_bytes(folder / "mask" / name, encode_png(mask));
    associations += fmt::format("{0:.6f} rgb/{1} {0:.6f} depth/{1}\n", 1000 + i / 30.0, name);
    cameras += row_of(i, frame.camera.camera_to_world);
    for (const testing::MovingThing& thing : scene.things) poses[thing.label] += row_of(i, thing.pose(i));
  }
  std::ofstream(folder / "associations.txt") << associations;
  std::ofstream(folder / "gt" / "camera_to_world.txt") << cameras;
  for (const auto& [label, rows] : poses) {
    if (label > 0) std::ofstream(folder / "gt" / fmt::format("object{}_to_world.txt", label)) << rows;
  }
  std::ofstream(folder / "intrinsics.json") << fmt::format(
      "{{\"width\": {}, \"height\": {}, \"fx\": {}, \"fy\": {}, \"cx\": {}, \"cy\": {}, "
      "\"depth_factor\": 1000, \"depth_unit\": \"mm\", \"fps\": 30}}\n",
      camera.width, camera.height, camera.focal, camera.focal, (camera.width - 1) / 2.0, (camera.height - 1) / 2.0);
}

} // namespace

int main(int argc, char** argv) {
  std::vector<std::string> names;
  bench::Knobs knobs{{"scene", {}}, {"seed", {1}}, {"frames", {0}}};
  for (const testing::ThingScene& scene : testing::thing_scenes()) {
    knobs["scene"].push_back(static_cast<double>(names.size()));
    names.emplace_back(scene.name);
  }
  std::string folder;
  try {
    bool usable = true;
    for (int i = 1; i < argc; ++i) {
      if (bench::set_knob(argv[i], knobs, names)) continue;
      usable = usable && folder.empty() && argv[i][0] != '-' && std::string(argv[i]).find('=') == std::string::npos;
      folder = argv[i];
    }
    if (!usable) {
      std::fprintf(stderr, "usage: %s [KNOB=VALUE,VALUE...] [FOLDER]; the knobs stand at the top of its source\n",
                   argv[0]);
      return 2;
    }
    std::printf("scene,label,mean_mm,worst_mm,rotation_mean,rotation_worst,axis_mean,axis_worst,turn_mean,turn_worst,"
                "seen,not_tracked,"
                "processor_ms,95_percent_ms\n");
    bench::run_all(knobs, [&](const bench::Setting& setting) {
      const testing::ThingScene& scene = testing::thing_scenes()[static_cast<std::size_t>(setting.at("scene"))];
      testing::ThingCamera camera;
      camera.seed = static_cast<std::uint64_t>(setting.at("seed"));
      const fs::path capture = folder.empty() ? fs::path() : fs::path(folder) / scene.name;
      if (!capture.empty() && !fs::exists(capture)) write_capture(scene, camera, capture);
      follow(scene, setting, camera, capture);
    });
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
