#include "player/view_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace kinora::player {
namespace {

constexpr int kProbeWidth = 64;         ///< of the small depth picture that the median is taken from
constexpr double kFallbackDistance = 2; ///< metres, when nothing is in front of the camera

std::optional<std::size_t> first_moving_layer(const Player& player) {
  const auto& layers = player.clip().layers;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i].motion.kind() != motion::MotionKind::kStill && player.centre_of(i, 0)) return i;
  }
  return std::nullopt;
}

/// Median depth of what is drawn between the fractions `from` and 1 − `from` of the picture's sides; 0: nothing is.
float median_depth(const DepthImage& depth, double from) {
  std::vector<float> depths;
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      const double x = (u + 0.5) / depth.width();
      const double y = (v + 0.5) / depth.height();
      if (depth.at(u, v) > 0 && std::min({x, y, 1 - x, 1 - y}) >= from) depths.push_back(depth.at(u, v));
    }
  }
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

/// Of what the camera is pointed at: the middle ninth of its picture, or else the whole.
double distance_of_subject(const Player& player, Camera camera, double frame) {
  const Intrinsics& full = camera.intrinsics;
  const int height = std::max(1, kProbeWidth * full.height / std::max(1, full.width));
  camera.intrinsics = full.resized(kProbeWidth, height);
  const fields::Picture picture = player.draw(camera, frame, player.all_layers());
  for (const double from : {1.0 / 3, 0.0}) {
    if (const float depth = median_depth(picture.depth, from); depth > 0) return depth;
  }
  return kFallbackDistance;
}

// The moving layer's centre averaged over the frames, so that the film's camera is steady.
Eigen::Vector3d mean_centre(const Player& player, std::size_t layer, const std::vector<int>& frames) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int frame : frames) sum += player.centre_of(layer, frame).value();
  return sum / static_cast<double>(frames.size());
}

} // namespace

std::vector<View> capture_views(const clip::Clip& clip, const std::vector<int>& frames) {
  std::vector<View> views;
  views.reserve(frames.size());
  for (const int frame : frames) {
    views.push_back({clip.capture_camera(frame), static_cast<double>(frame), fmt::format("{:06d}", frame)});
  }
  return views;
}

Eigen::Vector3d subject_of(const Player& player, int frame) {
  if (const auto moving = first_moving_layer(player)) return player.centre_of(*moving, frame).value();
  const Camera camera = player.clip().capture_camera(frame);
  return camera.camera_to_world * Eigen::Vector3d(0, 0, distance_of_subject(player, camera, frame));
}

Camera orbited(const Camera& camera, const Eigen::Vector3d& pivot, double radians) {
  const Eigen::Vector3d down = camera.camera_to_world.linear().col(1);
  // Seen along y (down) from above, a turn by −angle carries a camera that looks along +z to its right (+x).
  const SE3 orbit = Eigen::Translation3d(pivot) * Eigen::AngleAxisd(-radians, down) * Eigen::Translation3d(-pivot);
  return {camera.intrinsics, orbit * camera.camera_to_world};
}

std::vector<View> orbit_views(const Player& player, const std::vector<int>& frames, double degrees) {
  std::vector<View> views = capture_views(player.clip(), frames);
  if (views.empty()) return views;
  const auto moving = first_moving_layer(player);
  const Eigen::Vector3d centre = moving ? mean_centre(player, *moving, frames) : Eigen::Vector3d::Zero();
  const double distance = moving ? 0 : distance_of_subject(player, views.front().camera, views.front().frame);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double phase = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(views.size());
    const double swing = views.size() == 1 ? 1 : std::sin(phase);
    const Eigen::Vector3d ahead = views[i].camera.camera_to_world * Eigen::Vector3d(0, 0, distance);
    views[i].camera = orbited(views[i].camera, moving ? centre : ahead, swing * degrees * std::numbers::pi / 180);
  }
  return views;
}

} // namespace kinora::player
