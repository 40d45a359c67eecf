#include "bending_plate.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "core/sensor_noise.h"

namespace kinora::tracking::testing {
namespace {

constexpr double kFlat = 1e-6;
constexpr std::uint8_t kLabel = 2;

struct Hit {
  double depth;
  double x, y; ///< material
};

std::optional<Hit> hit_plate(const Plate& plate, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const auto at = [&](double t, double arc) -> std::optional<Hit> {
    const Hit hit{t, arc / (1 + plate.stretch), origin.y() + t * direction.y()};
    if (!(t > 0) || std::abs(hit.x) > plate.half_width || std::abs(hit.y) > plate.half_height) return std::nullopt;
    return hit;
  };
  if (std::abs(plate.curvature) < kFlat) {
    const double t = -origin.z() / direction.z();
    return at(t, origin.x() + t * direction.x());
  }
  // A cylinder about the line x = 0, z = 1/curvature.
  const double radius = 1 / plate.curvature;
  const double oz = origin.z() - radius;
  const double a = direction.x() * direction.x() + direction.z() * direction.z();
  const double b = origin.x() * direction.x() + oz * direction.z();
  const double c = origin.x() * origin.x() + oz * oz - radius * radius;
  const double root = b * b - a * c;
  if (root < 0) return std::nullopt;
  std::optional<Hit> first;
  for (const double sign : {-1.0, 1.0}) {
    const double t = (-b + sign * std::sqrt(root)) / a;
    const double x = origin.x() + t * direction.x();
    const double z = oz + t * direction.z();
    const double angle = radius > 0 ? std::atan2(x, -z) : std::atan2(x, z);
    const auto hit = at(t, angle * std::abs(radius));
    if (hit && (!first || hit->depth < first->depth)) first = hit;
  }
  return first;
}

double texture(double x, double y) {
  const double value = std::sin(90 * x + 40 * y) + std::sin(-50 * x + 80 * y) + std::sin(60 * x - 70 * y + 1) +
                       std::sin(30 * x + 20 * y + 2);
  return 0.45 + 0.1 * value;
}

} // namespace

Eigen::Vector3d Plate::position(double x, double y) const {
  const double arc = x * (1 + stretch);
  if (std::abs(curvature) < kFlat) return to_world * Eigen::Vector3d(arc, y, 0);
  return to_world *
         Eigen::Vector3d(std::sin(curvature * arc) / curvature, y, (1 - std::cos(curvature * arc)) / curvature);
}

ingest::Frame render_plate(const Plate& plate, const SE3& camera_to_world, int index, const SceneOptions& options) {
  ingest::Frame frame = grey_frame(camera_to_world, index, options);
  const SE3 camera_to_plate = plate.to_world.inverse() * camera_to_world;
  Random random(options.seed, static_cast<std::uint64_t>(index));
  for (int v = 0; v < options.height; ++v) {
    for (int u = 0; u < options.width; ++u) {
      const Eigen::Vector3d ray = camera_to_plate.linear() * frame.camera.intrinsics.unproject(u, v, 1.0);
      const std::optional<Hit> hit = hit_plate(plate, camera_to_plate.translation(), ray);
      double z = hit ? hit->depth : 4.0;
      if (hit) {
        frame.labels.at(u, v) = kLabel;
        const double level = std::clamp(255 * options.light * texture(hit->x, hit->y), 0.0, 255.0);
        for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = static_cast<std::uint8_t>(std::lround(level));
      }
      if (u < options.occluded_columns) {
        z = 0.5;
        frame.labels.at(u, v) = 1;
        for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = 200;
      }
      if (options.noise > 0) z += options.noise * kSensorNoise.sigma(z) * random.normal();
      frame.depth.at(u, v) = static_cast<float>(z);
    }
  }
  frame.clean_depth = frame.depth;
  return frame;
}

} // namespace kinora::tracking::testing
