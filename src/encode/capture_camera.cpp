#include "encode/capture_camera.h"

#include <map>
#include <string>

#include <fmt/format.h>

namespace kinora::encode {

using Json = nlohmann::json;

void CaptureCamera::place(ingest::Frame& frame, StageTimes& times) {
  if (!has_poses_) {
    frame.camera.camera_to_world = times.measure("track camera", [&] { return tracker_.track(frame).camera_to_world; });
  }
  given_.push_back(frame.camera.camera_to_world);
}

std::vector<SE3> CaptureCamera::path() const {
  if (has_poses_) return given_;
  if (tracker_.moves()) return tracker_.path();
  return {given_.begin(), given_.begin() + (given_.empty() ? 0 : 1)};
}

std::vector<SE3> CaptureCamera::corrections() const {
  if (has_poses_ || !tracker_.moves()) return {};
  std::vector<SE3> result = tracker_.path();
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = renormalized(result[i] * given_[i].inverse());
  return result;
}

Json CaptureCamera::json() const {
  if (has_poses_) return {{"path", "moving"}, {"why", "the capture brings one camera pose per frame"}};
  std::map<std::string, int> health{{"tracked", 0}, {"held", 0}, {"lost", 0}};
  for (const auto& result : tracker_.results()) ++health[std::string(tracking::name_of(result.health))];
  if (!tracker_.moves()) {
    return {{"path", "still"},
            {"why", "no stretch of frames is explained significantly better by another place of the camera"},
            {"frames", health}};
  }
  return {{"path", "moving"},
          {"why", fmt::format("from frame {} of the timeline on, the background is explained significantly better by "
                              "another place of the camera",
                              *tracker_.moving_from())},
          {"frames", health},
          {"key_frames", tracker_.keyframe_count()},
          {"loops", tracker_.loop_count()}};
}

} // namespace kinora::encode
