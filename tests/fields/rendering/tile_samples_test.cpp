#include "fields/rendering/tile_samples.h"

#include <functional>

#include <gtest/gtest.h>

namespace kinora::fields {
namespace {

constexpr std::uint32_t kTile = TileSamples::kTile;
constexpr float kSmall = 1.0F / 255;

bool is_between(std::uint32_t pixel) { return (pixel % kTile + pixel / kTile) % 2 != 0; }
bool is_corner(std::uint32_t pixel) {
  const std::uint32_t last = kTile - 1;
  return pixel % kTile % last == 0 && pixel / kTile % last == 0;
}

/// Slopes of colour and depth, as one layer shows them; nothing at the pixels between.
Sample gradient(std::uint32_t pixel) {
  const auto u = static_cast<float>(pixel % kTile);
  const std::uint32_t row = pixel / kTile;
  const auto v = static_cast<float>(row);
  Sample sample;
  sample.add(2, {0.5F + kSmall * u, 0.4F - kSmall * v, 0.3F, 7}, 1);
  sample.depth = 2 + 0.01F * u + 0.005F * v;
  sample.normal = Eigen::Vector3f::UnitZ();
  return sample;
}
TileSamples gradients() {
  TileSamples samples;
  samples.clear();
  for (std::uint32_t p = 0; p < kTile * kTile; ++p) {
    if (!is_between(p)) samples[p] = gradient(p);
  }
  return samples;
}

/// How many pixels between others are filled when `change` has been made to those in one place.
std::size_t filled_among_neighbours(std::uint32_t centre, const std::function<void(Sample&)>& change) {
  TileSamples samples = gradients();
  change(samples[centre]);
  std::size_t filled = 0;
  for (const std::uint32_t p : {centre - 1, centre + 1, centre - kTile, centre + kTile})
    filled += samples.fill(p) ? 1 : 0;
  return filled;
}

TEST(TileSamples, WhatLiesBetweenOnASlopeIsItsMiddle) {
  TileSamples samples = gradients();
  for (std::uint32_t p = 0; p < kTile * kTile; ++p) {
    if (!is_between(p)) continue;
    ASSERT_EQ(samples.fill(p), !is_corner(p)) << p;
    if (is_corner(p)) continue;
    const Sample expected = gradient(p);
    EXPECT_TRUE(samples[p].color.isApprox(expected.color, 1e-5F)) << p;
    EXPECT_NEAR(samples[p].depth, expected.depth, 1e-5F);
    EXPECT_TRUE(samples[p].normal.isApprox(expected.normal));
    EXPECT_EQ(samples[p].front, expected.front);
    EXPECT_EQ(samples[p].max_share, samples[p].color[3]);
  }
}

TEST(TileSamples, NothingIsFilledBesideOneThatDiffers) {
  for (const std::uint32_t centre : {kTile * 7 + 5, kTile * 1 + 1, kTile * 14 + 14}) {
    EXPECT_EQ(filled_among_neighbours(centre, [](Sample&) {}), 4U);
    EXPECT_EQ(filled_among_neighbours(centre, [](Sample& sample) { sample.color[1] += 10.0F / 255; }), 0U);
    EXPECT_EQ(filled_among_neighbours(centre, [](Sample& sample) { sample.color[2] -= 10.0F / 255; }), 0U);
    EXPECT_EQ(filled_among_neighbours(centre, [](Sample& sample) { sample.depth *= 1.04F; }), 0U);
    EXPECT_EQ(filled_among_neighbours(centre, [](Sample& sample) { sample.depth *= 0.96F; }), 0U);
    EXPECT_EQ(filled_among_neighbours(centre, [](Sample& sample) { sample.front = 1; }), 0U);
    EXPECT_EQ(filled_among_neighbours(centre, [](Sample& sample) { sample.max_share -= 0.01F; }), 0U) << "two layers";
    EXPECT_EQ(filled_among_neighbours(centre, [](Sample& sample) { sample = {}; }), 0U) << "nothing there";
  }
}

TEST(TileSamples, NothingIsFilledWhereLightPasses) {
  TileSamples samples = gradients();
  for (std::uint32_t p = 0; p < kTile * kTile; ++p) {
    samples[p].color *= 0.9F;
    samples[p].max_share *= 0.9F;
  }
  for (std::uint32_t p = 0; p < kTile * kTile; ++p) EXPECT_FALSE(is_between(p) && samples.fill(p)) << p;
}

TEST(TileSamples, ALineOnePixelWideIsNotFilledOver) {
  for (std::uint32_t line = 0; line < kTile; ++line) {
    for (const bool upright : {false, true}) {
      const auto is_on_line = [&](std::uint32_t p) { return (upright ? p % kTile : p / kTile) == line; };
      TileSamples samples = gradients();
      for (std::uint32_t p = 0; p < kTile * kTile; ++p) {
        if (!is_between(p) && is_on_line(p)) samples[p].color[2] = 0.9F;
      }
      for (std::uint32_t p = 0; p < kTile * kTile; ++p) {
        EXPECT_FALSE(is_between(p) && is_on_line(p) && samples.fill(p)) << line << ' ' << p;
      }
    }
  }
}

} // namespace
} // namespace kinora::fields
