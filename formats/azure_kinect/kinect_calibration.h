// The calibration that an Azure Kinect (and cameras that record as it does) attaches to its recordings.
// Source: Azure Kinect Sensor SDK, docs of k4a_calibration_t, and src/calibration for the crops of its modes.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/image.h"

namespace kinora::formats {

/// A lens with six radial and two tangential coefficients: more than the plugin interface knows, so that pictures are
/// straightened here.
struct RationalLens {
  Intrinsics intrinsics;
  double k[6] = {};             ///< radial: (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
  double p1 = 0, p2 = 0;        ///< tangential
  double max_radius = 0;        ///< of x/z and y/z that the calibration is valid for; 0: everywhere
  bool half_tangential = false; ///< the model Rational6KT
};

struct KinectCalibration {
  RationalLens color;
  RationalLens depth;
  SE3 depth_to_color = SE3::Identity();
};

/// For pictures of these sizes, which name the cameras' modes. Throws Error(kCorruptInput), naming `source`.
KinectCalibration read_kinect_calibration(std::span<const std::byte> json, int color_width, int color_height,
                                          int depth_width, int depth_height, const std::string& source);

/// Where each pixel of the straightened picture comes from.
class LensMap {
public:
  LensMap() = default;
  explicit LensMap(const RationalLens& lens);

  /// Between pixels; black outside of the picture.
  ColorImage straighten(const ColorImage& image) const;
  /// The nearest pixel, for depth must not be mixed; 0 outside of the picture.
  DepthImage16 straighten(const DepthImage16& image) const;

private:
  struct Source {
    float u, v; ///< outside of the picture: −1
  };
  int width_ = 0;
  int height_ = 0;
  std::vector<Source> sources_;
};

} // namespace kinora::formats
