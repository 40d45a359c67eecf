// Follows people of our own rounded cones who move their limbs as recorded people did, and compares the joints.
// One line of CSV for each combination of knobs: errors of seen and hidden wrists and of all joints, millimetres.
// Usage: bench_tracking_poses POSES [KNOB=VALUE,VALUE...]; POSES as `fit_pose_prior.py --poses` writes them: a line for
// each frame, four angles for each of the left and right arm and leg. turn: degrees from frame to frame; cover=1:
// something hides one arm and then the other for 25 frames; weight, trust: PosePriorConfig.
#include <cstdio>
#include <fstream>

#include <fmt/format.h>

#include "follow_label.h"
#include "knobs.h"
#include "tracking/body/body_tracker.h"
#include "tracking/body/synthetic_body.h"

namespace {

using namespace kinora;
using namespace kinora::tracking;

using LimbPoses = std::array<LimbAngles, kLimbs>;

std::vector<LimbPoses> read_poses(const std::string& path) {
  std::ifstream file(path);
  std::vector<LimbPoses> poses;
  LimbPoses pose;
  while (true) {
    for (LimbAngles& limb : pose) {
      for (double& angle : limb) file >> angle;
    }
    if (!file) return poses;
    poses.push_back(pose);
  }
}

BodyState posed(const LimbPoses& limbs, double rotation) {
  BodyState state = testing::standing(rotation);
  for (const Limb limb : kEveryLimb) {
    const LimbChain& chain = chain_of(limb);
    state.pose.angles.segment<3>(joints()[chain.ball].first_angle) = limbs[limb].head<3>();
    state.pose.angles[joints()[chain.hinge].first_angle] = std::max(0.0, limbs[limb][3]);
  }
  return state;
}

/// Nothing, the picture's left part and its right part, by turns.
std::optional<testing::Cover> cover_of(std::size_t frame) {
  constexpr std::size_t kFrames = 25;
  switch ((frame / kFrames) % 3) {
  case 1:
    return testing::Cover{122, 60, 160, 130};
  case 2:
    return testing::Cover{80, 60, 118, 130};
  default:
    return std::nullopt;
  }
}

std::string text(const std::vector<double>& errors) {
  if (errors.empty()) return ",";
  double sum = 0;
  for (const double error : errors) sum += error;
  return fmt::format("{:.1f},{:.1f}", sum / static_cast<double>(errors.size()), bench::at_fraction(errors, 0.95));
}

void follow(const std::vector<LimbPoses>& poses, const bench::Setting& knobs) {
  BodyTrackerConfig config;
  config.energy.poses.weight = knobs.at("weight");
  config.energy.poses.trust = knobs.at("trust");
  BodyTracker tracker(config);
  std::vector<double> seen;
  std::vector<double> hidden;
  std::vector<double> all;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const BodyState truth = posed(poses[i], knobs.at("turn") * static_cast<double>(i));
    testing::BodyScene scene;
    scene.seed = i;
    if (knobs.at("cover") != 0) scene.cover = cover_of(i);
    const LayerView view = view_label(testing::render_body(truth, scene), 1);
    const auto result = tracker.track(view, SE3::Identity(), static_cast<double>(i) / 30);
    for (const Limb limb : {kLeftArm, kRightArm}) {
      const double error = 1e3 * testing::joint_distance(tracker.state(), truth, chain_of(limb).end);
      (result.limbs[limb] == LimbHealth::kSeen ? seen : hidden).push_back(error);
    }
    all.push_back(1e3 * testing::mean_joint_distance(tracker.state(), truth));
  }
  for (const auto& [name, value] : knobs) std::printf("%g,", value);
  std::printf("%zu,%s,%zu,%s,%s\n", seen.size(), text(seen).c_str(), hidden.size(), text(hidden).c_str(),
              text(all).c_str());
  std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
  const PosePriorConfig defaults;
  bench::Knobs knobs{{"turn", {1}}, {"cover", {0}}, {"weight", {defaults.weight}}, {"trust", {defaults.trust}}};
  try {
    bool usable = argc > 1;
    for (int i = 2; i < argc; ++i) usable = usable && bench::set_knob(argv[i], knobs);
    const std::vector<LimbPoses> poses = usable ? read_poses(argv[1]) : std::vector<LimbPoses>();
    if (poses.empty()) {
      std::fprintf(stderr, "usage: %s POSES [turn=1] [cover=0] [weight=0.25] [trust=0.5]\n", argv[0]);
      return 2;
    }
    for (const auto& [name, values] : knobs) std::printf("%s,", name.c_str());
    std::printf("seen_wrists,mean_mm,95_percent_mm,hidden_wrists,mean_mm,95_percent_mm,joints_mean_mm,95_percent_mm\n");
    bench::run_all(knobs, [&](const bench::Setting& setting) { follow(poses, setting); });
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
