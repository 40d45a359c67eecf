#include "player/window/camera_recording.h"

namespace kinora::player::window {

void CameraRecording::add(const Camera& camera, double seconds) {
  Eigen::Matrix4d matrix = camera.camera_to_world.matrix();
  matrix.col(1) *= -1; // y down to y up
  matrix.col(2) *= -1; // z forward to z back
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
  const Intrinsics& k = camera.intrinsics;
  // There, pixel centres lie at half integers.
  nlohmann::json frame = {
      {"time", seconds}, {"transform_matrix", rows}, {"w", k.width},    {"h", k.height}, {"fl_x", k.fx},
      {"fl_y", k.fy},    {"cx", k.cx + 0.5},         {"cy", k.cy + 0.5}};
  if (frames_.empty() || frames_.back() != frame) frames_.push_back(std::move(frame));
}

std::string CameraRecording::text() const { return nlohmann::json{{"frames", frames_}}.dump(1) + "\n"; }

} // namespace kinora::player::window
