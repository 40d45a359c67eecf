#include "fields/analytic_scene.h"

#include <cmath>
#include <numbers>
#include <optional>

#include "core/random.h"

namespace kinora::bench {
namespace {

using Eigen::Vector3d;

struct Hit {
  double depth; // along the ray, in lengths of its direction
  Vector3d color;
};

/// Smooth, with detail down to about a centimetre.
Vector3d texture(const Vector3d& p, const Vector3d& tint) {
  const double coarse = 0.5 + 0.5 * std::sin(23 * p.x() + 5 * p.z()) * std::sin(19 * p.y() + 7 * p.x());
  const double fine = 0.5 + 0.5 * std::sin(90 * p.z() + 40 * p.y()) * std::sin(80 * p.x());
  return (tint * (0.35 + 0.45 * coarse) + Vector3d::Constant(0.2 * fine)).cwiseMin(1.0);
}

std::optional<double> sphere(const Vector3d& origin, const Vector3d& direction, const Vector3d& centre, double radius) {
  const Vector3d from = origin - centre;
  const double b = from.dot(direction) / direction.squaredNorm();
  const double root = b * b - (from.squaredNorm() - radius * radius) / direction.squaredNorm();
  if (root < 0 || -b - std::sqrt(root) <= 0) return std::nullopt;
  return -b - std::sqrt(root);
}

std::optional<double> box(const Vector3d& origin, const Vector3d& direction, const Vector3d& low,
                          const Vector3d& high) {
  const Vector3d a = (low - origin).cwiseQuotient(direction);
  const Vector3d b = (high - origin).cwiseQuotient(direction);
  const double enter = a.cwiseMin(b).maxCoeff();
  if (enter <= 0 || enter > a.cwiseMax(b).minCoeff()) return std::nullopt;
  return enter;
}

std::optional<Hit> first_hit(const Vector3d& origin, const Vector3d& direction) {
  std::optional<Hit> nearest;
  const auto add = [&](const std::optional<double>& depth, const Vector3d& tint) {
    if (!depth || (nearest && nearest->depth <= *depth)) return;
    nearest = Hit{*depth, texture(origin + *depth * direction, tint)};
  };
  add(sphere(origin, direction, {-0.18, -0.27, 0.05}, 0.22), {1, 0.5, 0.3});
  add(box(origin, direction, {0.08, -0.35, -0.3}, {0.38, -0.05, 0.0}), {0.4, 0.8, 0.5});
  add(box(origin, direction, {-0.5, -0.05, -0.5}, {0.5, 0.0, 0.5}), {0.6, 0.6, 0.95});
  return nearest;
}

ingest::Frame view(double azimuth, double elevation, int index, const AnalyticScene& wrong) {
  constexpr double kDistance = 1.5;
  constexpr int kSide = AnalyticScene::kSide;
  ingest::Frame frame;
  frame.index = index;
  frame.camera.intrinsics = {kSide, kSide, 300, 300, (kSide - 1) / 2.0, (kSide - 1) / 2.0};
  const Vector3d target(0, -0.15, 0);
  const Vector3d towards(std::cos(elevation) * std::sin(azimuth), -std::sin(elevation),
                         std::cos(elevation) * std::cos(azimuth));
  const Vector3d forward = -towards;
  const Vector3d right = Vector3d::UnitY().cross(forward).normalized(); // y points down
  Eigen::Matrix3d rotation;
  rotation << right, forward.cross(right), forward;
  frame.camera.camera_to_world = SE3::Identity();
  frame.camera.camera_to_world.linear() = rotation;
  frame.camera.camera_to_world.translation() = target + kDistance * towards;
  frame.color = ColorImage(kSide, kSide, 3);
  frame.depth = DepthImage(kSide, kSide);
  frame.labels = LabelImage(kSide, kSide);
  Random random(7, static_cast<std::uint64_t>(index));
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      const Vector3d direction = rotation * frame.camera.intrinsics.unproject(u, v, 1);
      const auto hit = first_hit(frame.camera.camera_to_world.translation(), direction);
      if (!hit) continue;
      frame.labels.at(u, v) = 1;
      frame.depth.at(u, v) = static_cast<float>(hit->depth + wrong.bias + wrong.noise * random.normal());
      for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = static_cast<std::uint8_t>(std::lround(255 * hit->color[c]));
    }
  }
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u + wrong.shift < kSide; ++u) frame.depth.at(u, v) = frame.depth.at(u + wrong.shift, v);
  }
  frame.clean_depth = frame.depth;
  return frame;
}

constexpr double kRotation = 2 * std::numbers::pi;
constexpr double kDegree = std::numbers::pi / 180;

} // namespace

ingest::Frame AnalyticScene::trained_view(int index) const {
  const double along = (index + 0.5) / kTrainedViews;
  return view(kRotation * 4 * along, (10 + 55 * along) * kDegree, index, *this);
}

ingest::Frame AnalyticScene::held_out_view(int index) const {
  return view(kRotation * (index + 0.37) / kHeldOutViews, (20 + 15 * index) * kDegree, kTrainedViews + index, {});
}

} // namespace kinora::bench
