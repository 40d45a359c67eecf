#include "synthetic_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "core/sensor_noise.h"

namespace kinora::tracking::testing {
namespace {

constexpr double kWall = 4.0;
constexpr double kOccluder = 0.5;
constexpr std::uint8_t kLabel = 2;

std::optional<double> intersect_box(const Eigen::Vector3d& half, const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
  double near = 0;
  double far = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(d[axis]) < 1e-12) {
      if (std::abs(o[axis]) > half[axis]) return std::nullopt;
      continue;
    }
    const double a = (-half[axis] - o[axis]) / d[axis];
    const double b = (half[axis] - o[axis]) / d[axis];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near < far && near > 0 ? std::optional(near) : std::nullopt;
}

std::optional<double> first_root(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return std::nullopt;
  const double root = (-b - std::sqrt(discriminant)) / a;
  return root > 0 ? std::optional(root) : std::nullopt;
}

std::optional<double> intersect_cylinder(const Shape& shape, const Eigen::Vector3d& o, const Eigen::Vector3d& d) {
  const double radius = shape.half.x();
  const auto side = first_root(d.x() * d.x() + d.z() * d.z(), o.x() * d.x() + o.z() * d.z(),
                               o.x() * o.x() + o.z() * o.z() - radius * radius);
  if (side && std::abs(o.y() + *side * d.y()) <= shape.half.y()) return side;
  return std::nullopt;
}

// A sum of waves through space: no two places alike, smooth at the size of a pixel.
double texture(const Eigen::Vector3d& p) {
  const double value = std::sin(140 * p.x() + 60 * p.y()) + std::sin(-50 * p.x() + 130 * p.y() + 30 * p.z()) +
                       std::sin(90 * p.z() - 70 * p.x()) + std::sin(110 * p.z() + 80 * p.y() + 1);
  return 0.45 + 0.1 * value;
}

} // namespace

std::optional<double> intersect(const Shape& shape, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  switch (shape.kind) {
  case ShapeKind::kBox:
    return intersect_box(shape.half, origin, direction);
  case ShapeKind::kSphere:
    return first_root(direction.squaredNorm(), origin.dot(direction),
                      origin.squaredNorm() - shape.half.x() * shape.half.x());
  case ShapeKind::kCylinder:
    return intersect_cylinder(shape, origin, direction);
  case ShapeKind::kPlane:
    break;
  }
  const double t = -origin.z() / direction.z();
  return t > 0 ? std::optional(t) : std::nullopt;
}

double distance_to(const Shape& shape, const Eigen::Vector3d& point) {
  if (shape.kind == ShapeKind::kSphere) return point.norm() - shape.half.x();
  if (shape.kind == ShapeKind::kPlane) return -point.z();
  const Eigen::Vector3d q = point.cwiseAbs() - shape.half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

ingest::Frame grey_frame(const SE3& camera_to_world, int index, const SceneOptions& options) {
  ingest::Frame frame;
  frame.index = index;
  frame.time = index / 30.0;
  frame.camera.intrinsics = {options.width, options.height,           options.focal,
                             options.focal, options.width / 2.0 - .5, options.height / 2.0 - .5};
  frame.camera.camera_to_world = camera_to_world;
  frame.color = ColorImage(options.width, options.height, 3, 128);
  frame.depth = DepthImage(options.width, options.height);
  frame.labels = LabelImage(options.width, options.height);
  return frame;
}

ingest::Frame render_frame(const Shape& shape, const SE3& object_to_world, const SE3& camera_to_world, int index,
                           const SceneOptions& options) {
  ingest::Frame frame = grey_frame(camera_to_world, index, options);
  const SE3 camera_to_object = object_to_world.inverse() * camera_to_world;
  const Eigen::Vector3d eye = camera_to_object.translation();
  Random random(options.seed, static_cast<std::uint64_t>(index));
  for (int v = 0; v < options.height; ++v) {
    for (int u = 0; u < options.width; ++u) {
      const Eigen::Vector3d ray = camera_to_object.linear() * frame.camera.intrinsics.unproject(u, v, 1.0);
      const std::optional<double> hit = intersect(shape, eye, ray);
      double z = hit.value_or(kWall);
      if (hit) {
        frame.labels.at(u, v) = kLabel;
        const double grey = shape.textured ? texture(eye + *hit * ray) : 0.5;
        const double level = std::clamp(255 * options.light * grey, 0.0, 255.0);
        for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = static_cast<std::uint8_t>(std::lround(level));
      }
      if (u < options.occluded_columns) {
        z = kOccluder;
        frame.labels.at(u, v) = options.occluder_has_label ? 1 : (hit ? kLabel : 0);
        for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = 200;
      }
      if (options.noise > 0) z += options.noise * kSensorNoise.sigma(z) * random.normal();
      frame.depth.at(u, v) = static_cast<float>(z);
    }
  }
  frame.clean_depth = frame.depth;
  return frame;
}

SE3 pose_at(const Eigen::Vector3d& centre, double x_degrees, double y_degrees, double z_degrees) {
  constexpr double kRadians = std::numbers::pi / 180;
  return Eigen::Translation3d(centre) * Eigen::AngleAxisd(z_degrees * kRadians, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(y_degrees * kRadians, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(x_degrees * kRadians, Eigen::Vector3d::UnitX());
}

} // namespace kinora::tracking::testing
