#include "fields/rendering/smooth_cells.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

namespace kinora::fields {
namespace {

constexpr std::uint32_t kTile = TriangleBins::kTile;

/// Cells whose anchors see a surface at `position`, relative to the box, where `has` says so.
SmoothCells cells_of(
    const std::function<float(float, float)>& depth,
    const std::function<bool(std::uint32_t)>& has = [](std::uint32_t) { return true; }) {
  SmoothCells cells;
  cells.clear();
  for (std::uint32_t p = 0; p < kTile * kTile; ++p) {
    if (!SmoothCells::is_anchor(p) || !has(p)) continue;
    const auto x = static_cast<float>(p % kTile);
    const std::uint32_t row = p / kTile;
    const auto y = static_cast<float>(row);
    const float z = depth(x, y);
    cells.set(p, {z, 1, 0, {0.001F * x, 0.001F * y, z}, {0, 0, 0.001F}});
  }
  cells.find_smooth_cells(0.002F);
  return cells;
}

TEST(SmoothCells, APlaneIsFilledExactly) {
  const auto plane = [](float x, float y) { return 0.5F + 0.004F * x - 0.003F * y; };
  const SmoothCells cells = cells_of(plane);
  for (std::uint32_t p = 0; p < kTile * kTile; ++p) {
    const auto surface = cells.at(p);
    ASSERT_TRUE(surface.has_value()) << p;
    const auto x = static_cast<float>(p % kTile);
    const std::uint32_t row = p / kTile;
    const auto y = static_cast<float>(row);
    EXPECT_NEAR(surface->depth, plane(x, y), 1e-6);
    EXPECT_NEAR(surface->position[0], 0.001F * x, 1e-6);
    EXPECT_NEAR(surface->position[1], 0.001F * y, 1e-6);
  }
}

TEST(SmoothCells, NothingIsFilledAcrossAStep) {
  for (std::uint32_t edge = 1; edge < kTile; ++edge) {
    const auto step = [edge](float x, float) { return x < static_cast<float>(edge) ? 0.5F : 0.51F; };
    const SmoothCells cells = cells_of(step);
    std::size_t filled = 0;
    for (std::uint32_t p = 0; p < kTile * kTile; ++p) {
      const auto surface = cells.at(p);
      if (!surface) continue;
      ++filled;
      EXPECT_TRUE(std::abs(surface->depth - 0.5F) < 1e-6F || std::abs(surface->depth - 0.51F) < 1e-6F)
          << edge << ' ' << p;
    }
    EXPECT_GT(filled, kTile * kTile / 2) << edge;
  }
}

TEST(SmoothCells, NothingIsFilledBesideAnAnchorThatSeesNone) {
  const std::uint32_t hole = 6 * kTile + 9;
  const SmoothCells cells = cells_of([](float, float) { return 0.5F; }, [](std::uint32_t p) { return p != hole; });
  for (std::uint32_t y = 4; y < 9; ++y) {
    for (std::uint32_t x = 7; x < 12; ++x) EXPECT_FALSE(cells.at(y * kTile + x).has_value()) << x << ' ' << y;
  }
  EXPECT_TRUE(cells.at(kTile + 1).has_value());
  EXPECT_FALSE(cells_of([](float, float) { return std::nanf(""); }).at(17).has_value());
}

} // namespace
} // namespace kinora::fields
