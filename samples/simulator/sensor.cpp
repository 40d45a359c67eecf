#include "sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/sensor_noise.h"

namespace kinora::simulator {
namespace {

/// Metres: depths that differ by more belong to two surfaces.
double jump_at(double z) { return std::max(0.035, 0.02 * z); }

constexpr double kGrazingCosine = 0.25; ///< flatter than that the pattern is not found

double srgb(double linear) { return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055; }

std::uint8_t byte_of(double value) { return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)); }

/// The other side of a jump in the 3×3 around a pixel, or its own depth.
double depth_beyond_jump(const DepthImage& truth, int u, int v) {
  const double z = truth.at(u, v);
  double other = z;
  for (int i = 0; i < 9; ++i) {
    const int x = std::clamp(u - 1 + i % 3, 0, truth.width() - 1);
    const int y = std::clamp(v - 1 + i / 3, 0, truth.height() - 1);
    const double near = truth.at(x, y);
    if (std::abs(near - z) > jump_at(z)) other = near > 0 ? near : z + 0.3;
  }
  return other;
}

bool is_grazing(const DepthImage& truth, const Intrinsics& k, int u, int v) {
  const int x = std::min(u + 1, truth.width() - 1);
  const int y = std::min(v + 1, truth.height() - 1);
  const Eigen::Vector3d here = k.unproject(u, v, truth.at(u, v));
  const Eigen::Vector3d across = k.unproject(x, v, truth.at(x, v)) - here;
  const Eigen::Vector3d down = k.unproject(u, y, truth.at(u, y)) - here;
  const Eigen::Vector3d normal = across.cross(down);
  return normal.norm() > 0 && std::abs(normal.normalized().dot(here.normalized())) < kGrazingCosine;
}

/// Places that the projector lights.
class Projector {
public:
  Projector(const std::vector<Surface>& surfaces, const Camera& camera, double baseline) : camera_(camera) {
    to_projector_.translation().x() = -baseline;
    camera_.camera_to_world = camera.camera_to_world * to_projector_.inverse();
    depth_ = rasterize(surfaces, camera_).depth;
  }
  bool lights(const Eigen::Vector3d& seen) const {
    const Eigen::Vector3d point = to_projector_ * seen;
    const Eigen::Vector2d at = camera_.intrinsics.project(point);
    const int u = static_cast<int>(std::lround(at.x()));
    const int v = static_cast<int>(std::lround(at.y()));
    return !depth_.contains(u, v) || point.z() < static_cast<double>(depth_.at(u, v)) + jump_at(point.z());
  }

private:
  Camera camera_;
  SE3 to_projector_ = SE3::Identity();
  DepthImage depth_;
};

void punch_holes(DepthImage16& depth, double count, Random& random) {
  for (; count > 0; --count) {
    const int u0 = static_cast<int>(random.below(static_cast<std::uint32_t>(depth.width())));
    const int v0 = static_cast<int>(random.below(static_cast<std::uint32_t>(depth.height())));
    const int radius = 1 + static_cast<int>(random.below(4));
    for (int v = v0 - radius; v <= v0 + radius; ++v)
      for (int u = u0 - radius; u <= u0 + radius; ++u)
        if (depth.contains(u, v) && (u - u0) * (u - u0) + (v - v0) * (v - v0) <= radius * radius) depth.at(u, v) = 0;
  }
}

} // namespace

DepthImage16 measure_depth(const std::vector<Surface>& surfaces, const Camera& camera, const DepthImage& truth,
                           const SensorFaults& faults, Random& random) {
  const Intrinsics& k = camera.intrinsics;
  const Projector projector(surfaces, camera, faults.baseline);
  DepthImage16 depth(truth.width(), truth.height());
  for (int v = 0; v < truth.height(); ++v) {
    for (int u = 0; u < truth.width(); ++u) {
      const double fate = random.uniform_double();
      const double between = random.uniform_double();
      const double noise = random.normal();
      double z = truth.at(u, v);
      if (z <= 0 || !projector.lights(k.unproject(u, v, z))) continue;
      const double other = depth_beyond_jump(truth, u, v);
      if (other == z && is_grazing(truth, k, u, v)) continue;
      if (other != z && fate < faults.lost_at_edges) continue;
      if (other != z && fate < faults.lost_at_edges + faults.flying_at_edges) z += between * (other - z);
      z += faults.noise * kSensorNoise.sigma(z) * noise;
      if (faults.disparity_step > 0) {
        const double steps = k.fx * faults.baseline / (z * faults.disparity_step);
        z = k.fx * faults.baseline / (std::max(1.0, std::round(steps)) * faults.disparity_step);
      }
      if (z > 0 && z <= faults.range) depth.at(u, v) = static_cast<std::uint16_t>(std::lround(1000 * z));
    }
  }
  punch_holes(depth, faults.holes, random);
  return depth;
}

ColorImage expose(const Image<float>& light, double seconds, const SensorFaults& faults, Random& random) {
  const double gain = 1 + faults.exposure_drift * std::sin(std::numbers::pi * seconds);
  ColorImage color(light.width(), light.height(), 3);
  for (std::size_t i = 0; i < light.values().size(); ++i) {
    const double value = gain * static_cast<double>(light.data()[i]);
    const double noise = faults.colour_noise * (0.5 + value) * random.normal(); // more photons, more noise
    color.data()[i] = byte_of(255 * srgb(value) + noise);
  }
  return color;
}

ColorImage expose(const Image<float>& light) {
  ColorImage color(light.width(), light.height(), 3);
  for (std::size_t i = 0; i < light.values().size(); ++i)
    color.data()[i] = byte_of(255 * srgb(static_cast<double>(light.data()[i])));
  return color;
}

} // namespace kinora::simulator
