#include "faulty_sensor.h"

#include <algorithm>
#include <cmath>

#include "core/sensor_noise.h"

namespace kinora::tracking::testing {
namespace {

double srgb(double linear) { return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055; }

} // namespace

// A jump: to a neighbour of the 3×3 around.
DepthImage measured(const DepthImage& truth, Random& random) {
  constexpr float kJump = 0.035F;
  constexpr double kLost = 0.5;
  constexpr double kFlying = 0.2;
  DepthImage depth(truth.width(), truth.height());
  for (int v = 1; v + 1 < truth.height(); ++v) {
    for (int u = 1; u + 1 < truth.width(); ++u) {
      const float z = truth.at(u, v);
      if (z <= 0) continue;
      float other = z;
      for (int i = 0; i < 9; ++i) {
        const float near = truth.at(u - 1 + i % 3, v - 1 + i / 3);
        if (std::abs(near - z) > kJump) other = near > 0 ? near : z + 0.3F;
      }
      const double fate = random.uniform_double();
      if (other != z && fate < kLost) continue;
      double seen = z;
      if (other != z && fate < kLost + kFlying) seen += random.uniform_double() * static_cast<double>(other - z);
      seen += kSensorNoise.sigma(seen) * random.normal();
      depth.at(u, v) = static_cast<float>(std::round(1e3 * seen) / 1e3);
    }
  }
  return depth;
}

ColorImage exposed(const Image<float>& light, Random& random) {
  ColorImage color(light.width(), light.height(), 3);
  for (std::size_t k = 0; k < light.values().size(); ++k) {
    const double value = 255 * srgb(static_cast<double>(light.values()[k])) + random.normal();
    color.values()[k] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
  }
  return color;
}

} // namespace kinora::tracking::testing
