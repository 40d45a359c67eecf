#include "player/view_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "player/subject.h"

namespace kinora::player {
namespace {

// The moving layer's centre averaged over those of the frames at which it is there, so that the film's camera is
// steady; the nearest one if it is at none.
Eigen::Vector3d mean_centre(const Player& player, std::size_t layer, const std::vector<int>& frames) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const int frame : frames) {
    const auto centre = player.centre_of(layer, frame);
    if (!centre) continue;
    sum += *centre;
    ++count;
  }
  return count > 0 ? Eigen::Vector3d(sum / count) : nearest_centre(player, layer, frames.front()).value();
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
  const Eigen::Vector3d centre = moving ? mean_centre(player, *moving, frames) : still_subject(player);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double phase = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(views.size());
    const double swing = views.size() == 1 ? 1 : std::sin(phase);
    views[i].camera = orbited(views[i].camera, centre, swing * degrees * std::numbers::pi / 180);
  }
  return views;
}

} // namespace kinora::player
