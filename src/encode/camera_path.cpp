#include "encode/camera_path.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "core/velocity.h"
#include "ingest/depth/registration.h"

namespace kinora::encode {
namespace {

std::size_t count_of(motion::Health health, const tracking::CameraTracker& tracker) {
  const auto& results = tracker.results();
  return static_cast<std::size_t>(
      std::count_if(results.begin(), results.end(), [health](const auto& result) { return result.health == health; }));
}

class PosedCapture final : public ingest::Capture {
public:
  PosedCapture(std::unique_ptr<ingest::Capture> capture, std::shared_ptr<const CameraPath> path)
      : capture_(std::move(capture)), path_(std::move(path)), info_(capture_->info()) {
    info_.has_poses = true;
  }

  const ingest::CaptureInfo& info() const override { return info_; }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return capture_->skipped(); }

  std::optional<ingest::Frame> next() override {
    std::optional<ingest::Frame> frame = capture_->next();
    if (!frame) return frame;
    const auto found = path_->camera_to_world.find(frame->index);
    if (found == path_->camera_to_world.end()) {
      throw Error(
          ErrorCode::kCorruptInput,
          fmt::format("frame {} could not be read before; leave the capture alone while it is encoded", frame->index));
    }
    frame->camera.camera_to_world = found->second;
    return frame;
  }

private:
  std::unique_ptr<ingest::Capture> capture_;
  std::shared_ptr<const CameraPath> path_;
  ingest::CaptureInfo info_;
};

class DepthInTime final : public ingest::Capture {
public:
  DepthInTime(std::unique_ptr<ingest::Capture> capture, std::shared_ptr<const CameraPath> path)
      : capture_(std::move(capture)), path_(std::move(path)) {}

  const ingest::CaptureInfo& info() const override { return capture_->info(); }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return capture_->skipped(); }

  std::optional<ingest::Frame> next() override {
    std::optional<ingest::Frame> frame = capture_->next();
    if (!frame) return frame;
    const double lag = path_->depth_lag + age_of_depth(*frame);
    if (lag == 0) return frame;
    const Intrinsics& intrinsics = frame->camera.intrinsics;
    const ingest::RegistrationGeometry geometry{intrinsics, intrinsics,
                                                tracking::depth_to_color(lag, velocity_at(*frame))};
    for (DepthImage* depth : {&frame->depth, &frame->clean_depth}) *depth = ingest::register_depth(*depth, geometry);
    return frame;
  }

private:
  // Seconds since it first came. Where a sensor measures depth less often than colour, frames repeat it to the bit; one
  // that repeats colour, too, is of the moment of the frame before.
  double age_of_depth(const ingest::Frame& frame) {
    constexpr double kMost = 0.1; // longer, and it has stopped, or nothing moves
    if (!last_ || !std::ranges::equal(last_->depth.values(), frame.depth.values())) {
      last_ = {frame.time, 0, frame.depth, frame.color};
    } else if (!std::ranges::equal(last_->color.values(), frame.color.values())) {
      last_->age = frame.time - last_->first_time;
      last_->color = frame.color;
    }
    return last_->age <= kMost ? last_->age : 0;
  }

  // From the frame before to the one after, as far as the path has them.
  Twist velocity_at(const ingest::Frame& frame) const {
    const auto& poses = path_->camera_to_world;
    const auto here = poses.lower_bound(frame.index);
    auto after = here != poses.end() && here->first == frame.index ? std::next(here) : here;
    if (after == poses.end()) --after;
    const auto before = here == poses.begin() ? here : std::prev(here);
    const double seconds = path_->times.at(after->first) - path_->times.at(before->first);
    return velocity_between(before->second, after->second, seconds);
  }

  struct Last {
    double first_time; ///< of the frames that show the same depth
    double age;        ///< seconds since then
    DepthImage depth;
    ColorImage color;
  };

  std::unique_ptr<ingest::Capture> capture_;
  std::shared_ptr<const CameraPath> path_;
  std::optional<Last> last_;
};

} // namespace

CameraPath follow_camera(ingest::Capture& capture, const tracking::CameraTrackerConfig& config, double depth_lag,
                         StageTimes& times, Progress& progress) {
  progress.stage("looking where the camera is", static_cast<std::size_t>(capture.info().frame_count));
  tracking::CameraTracker tracker(config);
  std::vector<int> indices;
  std::map<int, double> seconds;
  while (const auto frame = times.measure("read for the camera", [&] { return capture.next(); })) {
    progress.check();
    times.measure("track camera", [&] { tracker.track(*frame); });
    indices.push_back(frame->index);
    seconds[frame->index] = frame->time;
    progress.advance(indices.size(), "");
  }
  CameraPath path;
  path.origin = CameraPath::Origin::kFollowed;
  path.moving_from = tracker.moving_from();
  path.tracked = count_of(motion::Health::kTracked, tracker);
  path.held = count_of(motion::Health::kHeld, tracker);
  path.lost = count_of(motion::Health::kLost, tracker);
  path.key_frames = tracker.keyframe_count();
  path.loops = tracker.loop_count();
  if (!tracker.moves()) return path;
  const std::vector<SE3> poses = tracker.path();
  for (std::size_t i = 0; i < indices.size(); ++i) path.camera_to_world[indices[i]] = poses[i];
  path.times = std::move(seconds);
  path.depth_lag = depth_lag + tracker.depth_lag().value_or(0);
  return path;
}

std::unique_ptr<ingest::Capture> posed_capture(std::unique_ptr<ingest::Capture> capture,
                                               std::shared_ptr<const CameraPath> path) {
  if (!path->moves()) return capture;
  capture = depth_in_time(std::move(capture), path);
  return std::make_unique<PosedCapture>(std::move(capture), std::move(path));
}

std::unique_ptr<ingest::Capture> depth_in_time(std::unique_ptr<ingest::Capture> capture,
                                               std::shared_ptr<const CameraPath> path) {
  if (!path->moves()) return capture;
  return std::make_unique<DepthInTime>(std::move(capture), std::move(path));
}

} // namespace kinora::encode
