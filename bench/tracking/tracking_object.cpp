// Follows the object of a capture and compares it with the ground truth beside it: error at the object's centroid and
// milliseconds per frame, on the clock and of all processors together. Usage: bench_tracking_object CAPTURE [LABEL]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "evaluate/ground_truth.h"
#include "follow_label.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "tracking/rigid/rigid_tracker.h"

namespace {

using namespace kinora;
using bench::at_fraction;

struct Total {
  double sum = 0;
  double largest = 0;
  int count = 0;
  void add(double value) {
    sum += value;
    largest = std::max(largest, value);
    ++count;
  }
  double mean() const { return count > 0 ? sum / count : 0.0; }
};

class PoseErrors {
public:
  explicit PoseErrors(const std::optional<evaluate::GroundTruth>& truth) {
    if (!truth || !truth->object_centroid()) return;
    poses_ = truth->object_to_camera();
    centroid_ = *truth->object_centroid();
  }

  /// The motion since the first tracked frame against the true one, at the centroid. The capture camera is the world.
  void add(int frame, const motion::Motion::Pose& pose) {
    const auto now = poses_.find(frame);
    if (now == poses_.end() || pose.health == motion::Health::kLost) return;
    if (!first_) first_ = now->second;
    const SE3 motion = now->second * first_->inverse();
    const Eigen::Vector3d start = *first_ * centroid_;
    translation.add(1e3 * (pose.canonical_to_world * start - motion * start).norm());
    rotation.add(180 / std::numbers::pi * rotation_angle(pose.canonical_to_world.inverse() * motion));
  }

  Total translation; ///< millimetres
  Total rotation;    ///< degrees

private:
  std::map<int, SE3> poses_;
  Eigen::Vector3d centroid_ = Eigen::Vector3d::Zero();
  std::optional<SE3> first_;
};

void run(const std::string& folder, int label) {
  Progress silent;
  const host::PluginTable plugins = host::PluginTable::builtin();
  const auto capture = ingest::Capture::open(plugins, folder, {}, silent);
  PoseErrors errors(evaluate::GroundTruth::read(folder));
  std::vector<ingest::Frame> frames; // read beforehand: the next one would be read while this one is tracked
  while (auto frame = capture->next()) frames.push_back(std::move(*frame));
  tracking::RigidTracker tracker(label);
  std::vector<double> milliseconds;
  std::vector<double> processor_milliseconds;
  int not_tracked = 0;
  for (const ingest::Frame& frame : frames) {
    const std::clock_t processor_start = std::clock();
    const auto start = std::chrono::steady_clock::now();
    const tracking::RigidTrackingResult result = tracker.track(frame);
    milliseconds.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    processor_milliseconds.push_back(1e3 * static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC);
    if (result.pose.health != motion::Health::kTracked) ++not_tracked;
    errors.add(frame.index, result.pose);
  }
  std::printf("frames %zu, not tracked %d\n", milliseconds.size(), not_tracked);
  if (const auto non_rigidity = tracker.non_rigidity()) {
    std::printf("it bends, from frame %zu on, by up to %.1f mm\n", non_rigidity->first_frame,
                1e3 * non_rigidity->metres);
  }
  if (errors.translation.count > 0) {
    std::printf("translation at the centroid: mean %.2f mm, worst %.2f mm\n", errors.translation.mean(),
                errors.translation.largest);
    std::printf("rotation: mean %.2f degrees, worst %.2f degrees\n", errors.rotation.mean(), errors.rotation.largest);
  }
  std::printf("per frame: median %.1f ms, 99th percentile %.1f ms; of the processor %.1f, %.1f ms\n",
              at_fraction(milliseconds, 0.5), at_fraction(milliseconds, 0.99), at_fraction(processor_milliseconds, 0.5),
              at_fraction(processor_milliseconds, 0.99));
}

} // namespace

int main(int argc, char** argv) { return kinora::bench::follow_label(argc, argv, 2, run); }
