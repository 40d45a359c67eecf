#include "player/subject.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kinora::player {
namespace {

constexpr int kProbeWidth = 64;         ///< pixels, of the pictures that are looked at
constexpr int kProbes = 7;              ///< of them, spread evenly over the clip
constexpr double kMiddle = 0.2;         ///< σ of what counts as the middle, in picture heights
constexpr double kFallbackDistance = 2; ///< metres, when nothing is in front of the camera

struct WeightedPoint {
  Eigen::Vector3d point;
  double weight;
};

void add_seen_points(const Player& player, int frame, std::vector<WeightedPoint>& points) {
  Camera camera = player.clip().capture_camera(frame);
  const Intrinsics& full = camera.intrinsics;
  const int height = std::max(1, kProbeWidth * full.height / std::max(1, full.width));
  camera.intrinsics = full.resized(kProbeWidth, height);
  const DepthImage depth = player.preview(camera, frame, player.all_layers()).depth;
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      const double z = depth.at(u, v); // metres
      if (z <= 0) continue;
      const double x = (u + 0.5 - depth.width() / 2.0) / depth.height();
      const double y = (v + 0.5 - depth.height() / 2.0) / depth.height();
      const double weight = std::exp(-(x * x + y * y) / (2 * kMiddle * kMiddle)) / (z * z * z);
      points.push_back({camera.camera_to_world * camera.intrinsics.unproject(u, v, z), weight});
    }
  }
}

double weighted_median(std::vector<WeightedPoint>& points, int axis) {
  std::sort(points.begin(), points.end(),
            [axis](const WeightedPoint& a, const WeightedPoint& b) { return a.point[axis] < b.point[axis]; });
  double whole = 0;
  for (const WeightedPoint& p : points) whole += p.weight;
  double below = 0;
  for (const WeightedPoint& p : points) {
    below += p.weight;
    if (2 * below >= whole) return p.point[axis];
  }
  return points.back().point[axis];
}

} // namespace

std::optional<std::size_t> first_moving_layer(const Player& player) {
  const auto& layers = player.clip().layers;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i].motion.kind() != motion::MotionKind::kStill && nearest_centre(player, i, 0)) return i;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> nearest_centre(const Player& player, std::size_t layer, int frame) {
  const int count = static_cast<int>(player.frame_count());
  for (int away = 0; away < count; ++away) {
    for (const int candidate : {frame - away, frame + away}) {
      if (candidate < 0 || candidate >= count) continue;
      if (auto centre = player.centre_of(layer, candidate)) return centre;
    }
  }
  return std::nullopt;
}

Eigen::Vector3d still_subject(const Player& player) {
  const int last = static_cast<int>(player.frame_count()) - 1;
  const int probes = std::min(kProbes, last + 1);
  std::vector<WeightedPoint> points;
  for (int i = 0; i < probes; ++i) add_seen_points(player, probes == 1 ? 0 : i * last / (probes - 1), points);
  if (points.empty()) {
    return player.clip().capture_camera(std::max(0, last / 2)).camera_to_world *
           Eigen::Vector3d(0, 0, kFallbackDistance);
  }
  return {weighted_median(points, 0), weighted_median(points, 1), weighted_median(points, 2)};
}

Eigen::Vector3d subject_of(const Player& player, int frame) {
  if (const auto moving = first_moving_layer(player)) return nearest_centre(player, *moving, frame).value();
  return still_subject(player);
}

} // namespace kinora::player
