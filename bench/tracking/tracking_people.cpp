// Follows synthetic people in clothes (tests/tracking/body/person_scenes.h) as deforming layers and compares them with
// their own truth. One line of CSV for each scene: errors in millimetres of points that are seen, of those on the
// scene's fast parts, of hidden ones and of joints; frames that were not tracked; and the processor's time of a frame.
// Usage: bench_tracking_people [KNOB=VALUE,VALUE...]; scene: by name; height: of the picture, pixels; body=0: without
// bones; coarse, middle, fine: steps of each level, while each is worthwhile; seed: of the noise; frames=1 also tells
// it frame by frame.
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "knobs.h"
#include "stopwatch.h"
#include "track_errors.h"
#include "tracking/body/person_camera.h"
#include "tracking/deforming/deforming_tracker.h"

namespace {

using namespace kinora;
using namespace kinora::tracking;
using kinora::motion::Health;
using kinora::motion::Motion;

constexpr std::size_t kPoints = 600;

bench::Errors joint_errors(const testing::PersonScene& scene, const LayerBody& body) {
  bench::Errors errors;
  const auto paths = body.joint_paths();
  for (std::size_t frame = 0; paths && frame < paths->positions.size(); ++frame) {
    const Bones& truth = scene.at(static_cast<double>(frame)).body().body().bones;
    for (std::size_t j = 0; j < truth.size(); ++j) errors.add(paths->positions[frame][j], truth[j].translation());
  }
  return errors;
}

void follow(const bench::Setting& knobs) {
  const testing::PersonScene& scene = testing::person_scenes()[static_cast<std::size_t>(knobs.at("scene"))];
  testing::PersonCamera camera;
  const double scale = knobs.at("height") / camera.height;
  camera.width = static_cast<int>(std::lround(scale * camera.width));
  camera.height = static_cast<int>(std::lround(scale * camera.height));
  camera.focal *= scale;
  camera.seed = static_cast<std::uint64_t>(knobs.at("seed"));
  DeformingTrackerConfig config;
  config.binding.use_body = knobs.at("body") != 0;
  config.in_view.solver.min_decrease = knobs.at("worthwhile");
  std::size_t stage = 0;
  for (const char* name : {"coarse", "middle", "fine"}) {
    config.in_view.solver.iterations[stage++] = static_cast<int>(knobs.at(name));
  }
  DeformingTracker tracker(1, config);
  const bool each = knobs.at("frames") != 0;
  std::vector<double> processor;
  std::vector<int> numbers;
  int not_tracked = 0;
  for (int i = 0; i < scene.frames; ++i) {
    const ingest::Frame frame = testing::see_person(scene, i, camera);
    const bench::Stopwatch watch;
    const DeformingTrackingResult result = tracker.track(frame);
    processor.push_back(watch.processor_milliseconds());
    numbers.push_back(i);
    if (result.health != Health::kTracked) ++not_tracked;
    if (!each) continue;
    std::printf("# frame %d: %s, %zu nodes, inliers %.3f of %zu, empty %.3f, correlation %.3f, %.0f ms\n", i,
                std::string(name_of(result.health)).c_str(), result.nodes, result.quality.inlier_share(),
                result.quality.on_label, result.quality.free_space_share(), result.quality.texture_correlation,
                processor.back());
  }
  const TrackedLayer layer = std::move(tracker).finish().value();
  const Motion& motion = layer.motion;
  const auto all = bench::compare_tracks(testing::track_person(scene, kPoints, camera), motion, numbers, false);
  const auto fast =
      bench::compare_tracks(testing::track_person(scene, kPoints, camera, scene.fast_parts), motion, numbers, each);
  const LayerBody& body = layer.body;
  std::printf("# body: %s, explained %.3f, empty %.3f; %zu nodes\n", std::string(name_of(body.verdict())).c_str(),
              body.explained(), body.free_space(), motion.graph()->nodes().size());
  std::printf("%s,", std::string(scene.name).c_str());
  for (const auto& [name, value] : knobs) {
    if (name != "scene") std::printf("%g,", value);
  }
  std::printf("%s,%s,%s,%s,%d,%.0f,%.0f\n", all.visible.text().c_str(), fast.visible.text().c_str(),
              all.hidden.text().c_str(), joint_errors(scene, body).text().c_str(), not_tracked,
              bench::at_fraction(processor, 0.5), bench::at_fraction(processor, 0.95));
  std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
  std::vector<std::string> names;
  const std::array<int, 3> steps = DeformingAlignmentConfig().iterations;
  bench::Knobs knobs{{"scene", {}},
                     {"height", {480}},
                     {"body", {1}},
                     {"seed", {1}},
                     {"frames", {0}},
                     {"coarse", {static_cast<double>(steps[0])}},
                     {"middle", {static_cast<double>(steps[1])}},
                     {"fine", {static_cast<double>(steps[2])}},
                     {"worthwhile", {DeformingAlignmentConfig().min_decrease}}};
  for (const testing::PersonScene& scene : testing::person_scenes()) {
    knobs["scene"].push_back(static_cast<double>(names.size()));
    names.emplace_back(scene.name);
  }
  try {
    bool usable = true;
    for (int i = 1; i < argc; ++i) usable = usable && bench::set_knob(argv[i], knobs, names);
    if (!usable) {
      std::fprintf(stderr, "usage: %s [KNOB=VALUE,VALUE...]; the knobs stand at the top of its source\n", argv[0]);
      return 2;
    }
    std::printf("scene,body,coarse,fine,frames,height,middle,seed,worthwhile,seen_mean_mm,seen_median_mm,seen_95_"
                "percent_mm,fast_mean_mm,"
                "fast_median_mm,fast_95_percent_mm,hidden_mean_mm,hidden_median_mm,hidden_95_percent_mm,"
                "joints_mean_mm,joints_median_mm,joints_95_percent_mm,not_tracked,processor_ms,95_percent_ms\n");
    bench::run_all(knobs, follow);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
