// Follows the person of a capture by its skeleton, and compares its joints with the ground truth beside it
// (gt/joints.csv): milliseconds per frame without those for the view, and millimetres. A rig's joints are not where
// another's are: so there are errors as they are, and errors without each joint's constant offset in the space of its
// parent's bone. Usage: bench_tracking_body CAPTURE [LABEL]; with KINORA_BENCH_FRAMES set, also frame by
// frame; with KINORA_BENCH_BODY=FILE.npz the measures are those of a mesh at first; with KINORA_BENCH_ALONE set, nobody
// holds anything; with KINORA_BENCH_DETECTOR=SHARE a detector of joints is simulated from the ground truth (5 pixels of
// noise, 10 % misses and outliers), which exchanges left and right in that share of the frames;
// KINORA_BENCH_SEEN_ONLY: and finds nothing that is hidden.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>

#include "core/error.h"
#include "follow_label.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "nearby_objects.h"
#include "tracking/body/body_tracker.h"
#include "tracking/body/shape_from_mesh.h"
#include "tracking/body/simulated_detector.h"
#include "tracking/body/true_joints.h"
#include "tracking/view/deforming_view.h"

namespace {

using namespace kinora;
using bench::at_fraction;
using tracking::BodyTracker;
using tracking::Joint;

// Our joints and those of the sample captures' rig.
struct Match {
  Joint joint;
  const char* name;
};
constexpr std::array<Match, 19> kMatches = {{
    {tracking::kPelvis, "pelvis"},
    {tracking::kChest, "spine_03"},
    {tracking::kSpine, "spine_02"},
    {tracking::kNeck, "neck_01"},
    {tracking::kHead, "head"},
    {tracking::kLeftShoulder, "upperarm_l"},
    {tracking::kRightShoulder, "upperarm_r"},
    {tracking::kLeftElbow, "lowerarm_l"},
    {tracking::kRightElbow, "lowerarm_r"},
    {tracking::kLeftWrist, "hand_l"},
    {tracking::kRightWrist, "hand_r"},
    {tracking::kLeftHip, "thigh_l"},
    {tracking::kRightHip, "thigh_r"},
    {tracking::kLeftKnee, "calf_l"},
    {tracking::kRightKnee, "calf_r"},
    {tracking::kLeftAnkle, "foot_l"},
    {tracking::kRightAnkle, "foot_r"},
    {tracking::kLeftClavicle, "clavicle_l"},
    {tracking::kRightClavicle, "clavicle_r"},
}};

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

/// Truth minus estimate, in the parent's bone.
using Differences = std::array<std::vector<Eigen::Vector3d>, kMatches.size()>;

void compare(const tracking::Bones& bones, const std::map<std::string, Eigen::Vector3d>& truth, int frame,
             Differences& differences) {
  const bool each = std::getenv("KINORA_BENCH_FRAMES") != nullptr;
  if (each) std::printf("frame,%d", frame);
  for (std::size_t i = 0; i < kMatches.size(); ++i) {
    const auto found = truth.find(kMatches[i].name);
    if (found == truth.end()) continue;
    const int parent = std::max(0, tracking::joints()[kMatches[i].joint].parent);
    const Eigen::Vector3d difference = found->second - bones[kMatches[i].joint].translation();
    differences[i].push_back(bones[static_cast<std::size_t>(parent)].linear().transpose() * difference);
    if (each) std::printf(",%.0f", 1e3 * difference.norm());
  }
  if (each) std::printf("\n");
}

void print(const Differences& differences) {
  std::printf("joint,mean_mm,p95_mm,mean_without_offset_mm,p95_without_offset_mm\n");
  std::vector<double> all;
  std::vector<double> all_without;
  for (std::size_t i = 0; i < kMatches.size(); ++i) {
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& d : differences[i]) offset += d / static_cast<double>(differences[i].size());
    std::vector<double> raw;
    std::vector<double> without;
    for (const Eigen::Vector3d& d : differences[i]) {
      raw.push_back(1e3 * d.norm());
      without.push_back(1e3 * (d - offset).norm());
    }
    std::printf("%s,%.1f,%.1f,%.1f,%.1f\n", kMatches[i].name, mean_of(raw), at_fraction(raw, 0.95), mean_of(without),
                at_fraction(without, 0.95));
    all.insert(all.end(), raw.begin(), raw.end());
    all_without.insert(all_without.end(), without.begin(), without.end());
  }
  std::printf("all,%.1f,%.1f,%.1f,%.1f\n", mean_of(all), at_fraction(all, 0.95), mean_of(all_without),
              at_fraction(all_without, 0.95));
}

// The rig's names of COCO's joints; it has no face.
constexpr std::array<const char*, kinora::ingest::kDetectedJoints> kDetectable = {
    "",       "",       "",        "",        "",       "upperarm_l", "upperarm_r", "lowerarm_l", "lowerarm_r",
    "hand_l", "hand_r", "thigh_l", "thigh_r", "calf_l", "calf_r",     "foot_l",     "foot_r"};

void simulate_detector(const std::map<std::string, Eigen::Vector3d>& truth, int label, double swaps,
                       ingest::Frame& frame) {
  tracking::testing::JointPositions positions;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (const auto found = truth.find(kDetectable[i]); found != truth.end()) positions[i] = found->second;
  }
  tracking::testing::DetectorErrors errors;
  errors.swaps = swaps;
  errors.knows_hidden = std::getenv("KINORA_BENCH_SEEN_ONLY") == nullptr;
  frame.people.push_back({label, tracking::testing::detect_joints(positions, frame.camera.intrinsics, frame.depth,
                                                                  errors, static_cast<std::uint64_t>(frame.index))});
}

void run(const std::string& folder, int label) {
  Progress silent;
  const host::PluginTable plugins = host::PluginTable::builtin();
  const auto capture = ingest::Capture::open(plugins, folder, {}, silent);
  const tracking::testing::TrueJoints truth = tracking::testing::read_true_joints(folder);
  tracking::BodyTrackerConfig config;
  if (const char* body = std::getenv("KINORA_BENCH_BODY")) {
    config.known = tracking::measure_body(ingest::read_body_mesh(body));
  }
  BodyTracker tracker(config);
  bench::NearbyObjects objects(label);
  std::vector<double> milliseconds;
  std::vector<double> processor;
  Differences differences;
  double explained = 0;
  double empty = 0;
  int not_tracked = 0;
  while (auto frame = capture->next()) {
    const auto found = truth.find(frame->index);
    const char* swaps = std::getenv("KINORA_BENCH_DETECTOR");
    if (swaps != nullptr && found != truth.end()) {
      simulate_detector(found->second, label, std::atof(swaps), *frame);
    }
    const tracking::LayerView view = tracking::view_layer(*frame, label);
    std::vector<tracking::NearbyObject> nearby;
    if (std::getenv("KINORA_BENCH_ALONE") == nullptr) nearby = objects.follow(*frame);
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t processor_start = std::clock();
    const tracking::BodyTrackingResult result = tracker.track(view, frame->camera.camera_to_world, frame->time, nearby);
    milliseconds.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    processor.push_back(1e3 * static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC);
    explained += result.explained;
    empty += result.free_space_share;
    if (result.health != motion::Health::kTracked) ++not_tracked;
    if (!tracker.started()) continue;
    const tracking::Bones bones = tracking::forward_kinematics(tracker.state().pose, tracker.state().shape);
    if (std::getenv("KINORA_BENCH_FRAMES") != nullptr) {
      std::printf("health,%d,%s,%.3f,%.3f", frame->index, std::string(motion::name_of(result.health)).c_str(),
                  result.explained, result.free_space_share);
      for (const tracking::LimbHealth limb : result.limbs) std::printf(",%s", std::string(name_of(limb)).c_str());
      std::printf(",%.1f\n", milliseconds.back());
    }
    if (found != truth.end()) compare(bones, found->second, frame->index, differences);
  }
  const auto frames = static_cast<double>(std::max<std::size_t>(1, milliseconds.size()));
  std::printf(
      "frames,not_tracked,explained,empty,median_ms,p99_ms,median_processor_ms\n%zu,%d,%.3f,%.3f,%.2f,%.2f,%.2f\n",
      milliseconds.size(), not_tracked, explained / frames, empty / frames, at_fraction(milliseconds, 0.5),
      at_fraction(milliseconds, 0.99), at_fraction(processor, 0.5));
  if (!truth.empty()) print(differences);
}

} // namespace

int main(int argc, char** argv) { return kinora::bench::follow_label(argc, argv, 1, run); }
