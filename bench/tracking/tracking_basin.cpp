// How far a person, or an arm, may jump between two frames and still be found: the basin of convergence of
// DeformingTracker, from jumps of tests/tracking/body/person_jumps.h. One line of CSV for each jump, setting and size:
// errors in millimetres of the points that jumped, of all trials, in the first frame after the jump and in the last;
// and the share of trials whose mean error is then below 10 mm, and below 30 mm (an arm that is found, but rolled about
// itself). Trials that show less than five of the points before and after do not count.
// Settings: full: as it is; plain: what Instant-NVR says of its tracker: skeleton and graph are aligned to depth alone
// from where they are expected (no colour, no silhouette of the graph, no search); graph: the same without skeleton.
// Usage: bench_tracking_basin [KNOB=VALUE,VALUE...]; jump, setting: by name; size: centimetres (those to 30) or
// degrees; trials: how many; height: of the picture, pixels; each=1 also tells each trial.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "knobs.h"
#include "track_errors.h"
#include "tracking/body/person_jumps.h"
#include "tracking/deforming/deforming_tracker.h"

namespace {

using namespace kinora;
using namespace kinora::tracking;
using kinora::motion::Health;
using kinora::motion::Motion;

constexpr std::size_t kPoints = 2000;
constexpr std::size_t kMinPoints = 5;
constexpr double kConverged = 10; // millimetres, mean
constexpr double kFound = 30;     // likewise
constexpr double kLargestShift = 30;
enum Setting { kFull, kPlain, kGraph, kSettings };
constexpr std::array<const char*, kSettings> kSettingNames = {"full", "plain", "graph"};

DeformingTrackerConfig config_of(Setting setting) {
  DeformingTrackerConfig config;
  if (setting != kFull) {
    config.use_searches = false;
    config.binding.body.tracker.use_searches = false;
    config.in_view.solver.silhouette_weight = 0;
  }
  config.binding.use_body = setting != kGraph;
  return config;
}

/// Of all trials of one jump, setting and size.
struct Outcome {
  bench::Errors first, last; ///< in the first frame after the jump, and in the last
  int converged = 0, found = 0, trials = 0, not_tracked = 0;
};

bench::Errors in_millimetres(const std::vector<double>& metres) {
  bench::Errors errors;
  for (const double error : metres) errors.values.push_back(1e3 * error);
  return errors;
}

void append(const bench::Errors& some, bench::Errors& all) {
  all.values.insert(all.values.end(), some.values.begin(), some.values.end());
}

void follow(const testing::PersonScene& scene, std::vector<ingest::Frame> frames, const testing::PersonCamera& camera,
            Setting setting, double size, bool each, Outcome& outcome) {
  DeformingTracker tracker(1, config_of(setting));
  for (ingest::Frame& frame : frames) {
    if (setting != kFull) std::ranges::fill(frame.color.values(), std::uint8_t{128});
    if (tracker.track(frame).health != Health::kTracked) ++outcome.not_tracked;
  }
  const Motion motion = tracker.motion();
  const auto errors = [&](int frame) {
    return in_millimetres(testing::errors_after_jump(scene, motion, frames.size(), frame, camera, kPoints));
  };
  const bench::Errors last = errors(testing::kJumpFrames - 1);
  if (each) {
    std::printf("# %s %g, trial %d, %s: %s mm of %zu points\n", std::string(scene.name).c_str(), size,
                static_cast<int>(camera.seed), kSettingNames[setting], last.text().c_str(), last.values.size());
  }
  if (last.values.size() < kMinPoints) return;
  append(errors(testing::kJumpFrame), outcome.first);
  append(last, outcome.last);
  if (last.mean() < kConverged) ++outcome.converged;
  if (last.mean() < kFound) ++outcome.found;
  ++outcome.trials;
}

bool is_shift(testing::Jump jump) { return jump == testing::Jump::kPersonShift || jump == testing::Jump::kHandShift; }

void measure(testing::Jump jump, bench::Knobs& knobs) {
  testing::PersonCamera camera;
  const double scale = knobs["height"].front() / camera.height;
  camera.width = static_cast<int>(std::lround(scale * camera.width));
  camera.height = static_cast<int>(std::lround(scale * camera.height));
  camera.focal *= scale;
  std::map<std::pair<double, double>, Outcome> outcomes; // by setting and size
  for (std::uint64_t trial = 0; trial < static_cast<std::uint64_t>(knobs["trials"].front()); ++trial) {
    camera.seed = trial;
    std::vector<ingest::Frame> frames;
    for (const double size : knobs["size"]) {
      if (is_shift(jump) && size > kLargestShift) continue;
      const testing::PersonScene scene = testing::jumping_person(jump, is_shift(jump) ? size / 100 : size, trial);
      frames.resize(std::min<std::size_t>(frames.size(), testing::kJumpFrame)); // before it all sizes are alike
      while (frames.size() < testing::kJumpFrames) {
        frames.push_back(testing::see_person(scene, static_cast<int>(frames.size()), camera));
      }
      for (const double setting : knobs["setting"]) {
        follow(scene, frames, camera, static_cast<Setting>(setting), size, knobs["each"].front() != 0,
               outcomes[{setting, size}]);
      }
    }
  }
  for (const auto& [key, outcome] : outcomes) {
    const double trials = outcome.trials;
    std::printf("%s,%s,%g,%s,%s,%.3f,%.3f,%d,%d\n", std::string(name_of(jump)).c_str(),
                kSettingNames[static_cast<std::size_t>(key.first)], key.second, outcome.first.text().c_str(),
                outcome.last.text().c_str(), outcome.converged / trials, outcome.found / trials, outcome.not_tracked,
                outcome.trials);
  }
  std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
  bench::Knobs knobs{{"jump", {0, 1, 2, 3}}, {"setting", {kFull, kPlain, kGraph}},
                     {"trials", {12}},       {"size", {5, 10, 15, 20, 25, 30, 35, 40}},
                     {"height", {360}},      {"each", {0}}};
  try {
    bool usable = true;
    std::vector<std::string> jumps(testing::kEveryJump.size());
    std::ranges::transform(testing::kEveryJump, jumps.begin(), [](testing::Jump jump) { return name_of(jump); });
    const std::vector<std::string> settings(kSettingNames.begin(), kSettingNames.end());
    for (int i = 1; i < argc; ++i) {
      const bool is_setting = std::string(argv[i]).starts_with("setting=");
      usable = usable && bench::set_knob(argv[i], knobs, is_setting ? settings : jumps);
    }
    if (!usable) {
      std::fprintf(stderr, "usage: %s [KNOB=VALUE,VALUE...]; the knobs stand at the top of its source\n", argv[0]);
      return 2;
    }
    std::printf("jump,setting,size,first_mean_mm,first_median_mm,first_95_percent_mm,mean_mm,median_mm,95_percent_mm,"
                "converged,found,not_tracked,trials\n");
    for (const double jump : knobs["jump"]) measure(testing::kEveryJump[static_cast<std::size_t>(jump)], knobs);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
