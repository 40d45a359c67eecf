// How far what is drawn lies beside what the capture shows, in pixels.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "core/image.h"

namespace kinora::evaluate {

/// Lengths of the optical flow from drawn pictures to true ones, over all pixels of many pairs. Wrong poses, motion,
/// registration or shape move edges, which decibels alone do not tell from blur and noise.
class PictureShift {
public:
  /// `drawn`: sRGB and straight alpha; pixels of which less than half is drawn do not count. `truth`: sRGB, 3 channels,
  /// as large; pictures smaller than 16 pixels do not count either. Not thread-safe (ingest/images/optical_flow.h).
  ///
  void add(const ColorImage& drawn, const ColorImage& truth);

  /// `shift_median` and `shift_95`, the value that 95 % of the pixels do not exceed: pixels, to a hundredth, up to 64;
  /// null if nothing was drawn, or OpenCV is not installed.
  nlohmann::json json() const;

private:
  static constexpr int kBinsPerPixel = 100;
  static constexpr int kLongest = 64;  ///< pixels
  static constexpr int kSmallest = 16; ///< pixels on a side: the flow needs 12
  std::vector<std::size_t> counts_ = std::vector<std::size_t>(kBinsPerPixel * kLongest + 1, 0);
};

} // namespace kinora::evaluate
