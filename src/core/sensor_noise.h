// The noise of structured-light and time-of-flight depth along the optical axis.
// Source: Nguyen, Izadi, Lovell, "Modeling Kinect Sensor Noise for Improved 3D Reconstruction and Tracking", 2012.
#pragma once

#include <algorithm>

namespace kinora {

/// Standard deviations of measured depths, in metres, by the depth z in metres. In lanes: sensor_noise_simd.h.
struct SensorNoise {
  /// Of the depths at hand, in standard deviations of the sensor: poses and motion that are a little wrong add to it.
  float scale = 1;

  /// Along the optical axis: 1.2 mm + 1.9 mm·(z − 0.4)², by the scale.
  constexpr double sigma(double z) const { return static_cast<double>(scale) * sensor_sigma(z); }
  /// Three of them: 0.3 % of normal errors are larger.
  constexpr float three_sigma(float z) const { return scale * static_cast<float>(3.0 * sensor_sigma(z)); }
  /// Across a surface whose normal has this cosine, from 0, to the ray, which noise lies along. One that is seen
  /// flatter than at kMinCosine is not taken to be known any better for that.
  constexpr double sigma_across(double z, double cosine) const { return sigma(z) * std::max(kMinCosine, cosine); }

  static constexpr double kMinSigma = 0.0012; ///< metres, at …
  static constexpr double kNearest = 0.4;     ///< metres
  static constexpr double kGrowth = 0.0019;   ///< metres, a metre beyond that
  static constexpr double kMinCosine = 0.3;

private:
  static constexpr double sensor_sigma(double z) { return kMinSigma + kGrowth * (z - kNearest) * (z - kNearest); }
};

/// That of the sensor itself.
inline constexpr SensorNoise kSensorNoise{};

/// Three standard deviations of the difference of two measurements at one depth, in those of one: 3·√2.
inline constexpr double kThreeSigmaOfDifference = 4.25;

} // namespace kinora
