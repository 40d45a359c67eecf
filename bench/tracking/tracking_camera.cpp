// Follows the camera of a capture, whose poses are hidden from the tracker, and compares it with them: absolute
// trajectory error (root mean square) after rigid alignment of both paths and with the first frames laid together,
// errors from frame to frame, and milliseconds per frame. A capture without poses has a still camera.
// Usage: bench_tracking_camera CAPTURE [LABELS]: 0 leaves the capture's masks unread (default 1); with
// KINORA_BENCH_FRAMES set, also frame by frame.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <numbers>

#include "core/error.h"
#include "follow_label.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "tracking/camera/camera_tracker.h"

namespace {

using namespace kinora;
using bench::at_fraction;

double rms(const std::vector<double>& values) {
  double squares = 0;
  for (const double value : values) squares += value * value;
  return values.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(values.size()));
}

// Distances between both paths' positions, with the estimate laid onto the truth by least squares (Umeyama, 1991).
std::vector<double> aligned_errors(const std::vector<SE3>& estimate, const std::vector<SE3>& truth) {
  Eigen::Matrix3Xd from(3, static_cast<Eigen::Index>(estimate.size()));
  Eigen::Matrix3Xd to(3, static_cast<Eigen::Index>(truth.size()));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = estimate[i].translation();
    to.col(static_cast<Eigen::Index>(i)) = truth[i].translation();
  }
  const Eigen::Matrix4d onto = Eigen::umeyama(from, to, false);
  std::vector<double> errors;
  for (Eigen::Index i = 0; i < from.cols(); ++i) {
    errors.push_back(1e3 * (onto.topLeftCorner<3, 3>() * from.col(i) + onto.topRightCorner<3, 1>() - to.col(i)).norm());
  }
  return errors;
}

void compare(const std::vector<SE3>& estimate, const std::vector<SE3>& truth) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  std::vector<double> first;
  std::vector<double> steps;
  std::vector<double> rotations;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const SE3 to_first = truth.front() * estimate.front().inverse() * estimate[i];
    first.push_back(1e3 * (to_first.translation() - truth[i].translation()).norm());
    if (i == 0) continue;
    const SE3 step = (truth[i - 1].inverse() * truth[i]).inverse() * (estimate[i - 1].inverse() * estimate[i]);
    steps.push_back(1e3 * step.translation().norm());
    rotations.push_back(kDegrees * rotation_angle(step));
  }
  const std::vector<double> aligned = aligned_errors(estimate, truth);
  std::printf("trajectory error: %.2f mm aligned, worst %.2f mm; %.2f mm from the first frame, worst %.2f mm\n",
              rms(aligned), at_fraction(aligned, 1), rms(first), at_fraction(first, 1));
  std::printf("from frame to frame: %.2f mm, worst %.2f mm; %.3f degrees, worst %.3f degrees\n", rms(steps),
              at_fraction(steps, 1), rms(rotations), at_fraction(rotations, 1));
}

void run(const std::string& folder, int labels) {
  Progress silent;
  const host::PluginTable plugins = host::PluginTable::builtin();
  ingest::CaptureOptions options;
  options.use_masks = labels != 0;
  const auto capture = ingest::Capture::open(plugins, folder, options, silent);
  tracking::CameraTracker tracker;
  std::vector<double> milliseconds;
  std::vector<double> processor;
  std::vector<SE3> truth;
  std::map<motion::Health, int> health;
  std::vector<ingest::Frame> frames; // read beforehand: the next one would be read while this one is tracked
  while (auto frame = capture->next()) frames.push_back(std::move(*frame));
  for (ingest::Frame& frame : frames) {
    truth.push_back(frame.camera.camera_to_world);
    frame.camera.camera_to_world = SE3::Identity();
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t processor_start = std::clock();
    const tracking::CameraTrackingResult result = tracker.track(frame);
    milliseconds.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    processor.push_back(1e3 * static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC);
    ++health[result.health];
    if (std::getenv("KINORA_BENCH_FRAMES") != nullptr) {
      const SE3 expected = truth.front().inverse() * truth.back();
      std::printf("frame %d: %s, %.1f mm off, share %.2f, texture %.2f, %d weak, %.1f ms\n", frame.index,
                  std::string(motion::name_of(result.health)).c_str(),
                  1e3 * (expected.translation() - result.camera_to_world.translation()).norm(),
                  result.quality.inlier_share(), result.quality.texture_correlation, result.degenerate_directions,
                  milliseconds.back());
    }
  }
  std::printf("frames %zu: tracked %d, held %d, lost %d; %s from frame %zu, %zu key frames, %zu loops\n",
              milliseconds.size(), health[motion::Health::kTracked], health[motion::Health::kHeld],
              health[motion::Health::kLost], tracker.moves() ? "moving" : "still", tracker.moving_from().value_or(0),
              tracker.keyframe_count(), tracker.loop_count());
  compare(tracker.path(), truth);
  if (const auto lag = tracker.depth_lag()) std::printf("depth comes %.1f ms later than colour\n", 1e3 * *lag);
  std::printf("per frame: median %.1f ms, 99th percentile %.1f ms; processor median %.1f ms, 99th percentile %.1f ms\n",
              at_fraction(milliseconds, 0.5), at_fraction(milliseconds, 0.99), at_fraction(processor, 0.5),
              at_fraction(processor, 0.99));
}

} // namespace

int main(int argc, char** argv) { return kinora::bench::follow_label(argc, argv, 1, run); }
