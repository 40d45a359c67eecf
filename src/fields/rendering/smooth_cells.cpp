#include "fields/rendering/smooth_cells.h"

#include <algorithm>

namespace kinora::fields {
namespace {

Surface interpolate(const Surface& a, const Surface& b, float share) {
  const auto mix = [share](float from, float to) { return from + share * (to - from); };
  Surface surface = a;
  surface.depth = mix(a.depth, b.depth);
  surface.opacity = mix(a.opacity, b.opacity);
  for (std::size_t i = 0; i < 3; ++i) {
    surface.position[i] = mix(a.position[i], b.position[i]);
    surface.sigma[i] = mix(a.sigma[i], b.sigma[i]);
  }
  return surface;
}

} // namespace

// The edge between two neighbours in a row of anchors: straight if it goes on as the row does before or after it. A
// step of depth would be seen from both sides.
bool SmoothCells::is_straight(std::size_t from, std::size_t stride, std::size_t index, float tolerance) const {
  const auto is_curved = [&](std::size_t first) {
    const std::size_t middle = first + stride;
    const std::size_t last = middle + stride;
    if (!solid_[first] || !solid_[middle] || !solid_[last]) return true;
    float sum = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const float curvature =
          surfaces_[first].position[a] - 2 * surfaces_[middle].position[a] + surfaces_[last].position[a];
      sum += curvature * curvature;
    }
    return !(sum <= tolerance * tolerance);
  };
  return (index > 0 && !is_curved(from - stride)) || (index + 2 < kAnchors && !is_curved(from));
}

void SmoothCells::find_smooth_cells(float tolerance) {
  constexpr std::size_t kSide = kAnchors;
  smooth_.fill(false);
  for (std::size_t y = 0; y + 1 < kSide; ++y) {
    for (std::size_t x = 0; x + 1 < kSide; ++x) {
      const std::size_t i = y * kSide + x;
      smooth_[i] = solid_[i] && solid_[i + 1] && solid_[i + kSide] && solid_[i + kSide + 1] &&
                   is_straight(i, 1, x, tolerance) && is_straight(i + kSide, 1, x, tolerance) &&
                   is_straight(i, kSide, y, tolerance) && is_straight(i + 1, kSide, y, tolerance);
    }
  }
}

std::optional<Surface> SmoothCells::at(std::uint32_t pixel) const {
  constexpr std::uint32_t kTile = TriangleBins::kTile;
  const std::uint32_t u = pixel % kTile;
  const std::uint32_t v = pixel / kTile;
  const std::uint32_t x = std::min<std::uint32_t>(u / kStep, kAnchors - 2);
  const std::uint32_t y = std::min<std::uint32_t>(v / kStep, kAnchors - 2);
  const std::size_t i = y * kAnchors + x;
  if (!smooth_[i]) return std::nullopt;
  const float along = static_cast<float>(u - kStep * x) / kStep;
  const float down = static_cast<float>(v - kStep * y) / kStep;
  return interpolate(interpolate(surfaces_[i], surfaces_[i + 1], along),
                     interpolate(surfaces_[i + kAnchors], surfaces_[i + kAnchors + 1], along), down);
}

} // namespace kinora::fields
