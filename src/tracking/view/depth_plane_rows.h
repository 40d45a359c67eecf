// The inner loop of fit_depth_planes: planes of the pixels of a row, vectorised with Highway and chosen at run time for
// the processor. tests/tracking/view/depth_planes_test.cpp keeps it equal to a plain loop.
#pragma once

#include <array>
#include <cstddef>

namespace kinora::tracking {

/// Rows of an image from two above a pixel's own to two below it, and its camera.
struct PlaneRows {
  static constexpr std::size_t kRadius = 2;
  static constexpr std::size_t kRows = 2 * kRadius + 1;
  static constexpr std::size_t kMargin = 16 + kRadius; ///< numbers that can be read before and after a row's pixels
  static constexpr float kNone = -1e6F;                ///< depth beyond every gate: drops out of all sums

  std::array<const float*, kRows> depth;   ///< metres; kNone where none may be used
  std::array<const float*, kRows> inverse; ///< of it; 0 there
  float fx, fy, cx;                        ///< pixels
  float y;                                 ///< of the row's rays: (v − cy) / fy
};

/// Writes planes (four numbers of each pixel) and weights of the row's pixels from `begin` to `end`, excluded, as
/// DepthPlanes has them; zero where there is no plane.
void fit_row(const PlaneRows& rows, std::size_t begin, std::size_t end, float* planes, float* weights);

} // namespace kinora::tracking
