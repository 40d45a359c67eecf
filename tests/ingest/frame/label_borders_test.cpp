#include "ingest/frame/label_borders.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/random.h"

namespace kinora::ingest {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

/// A person 2 m away before a wall that is out of range, and a box before the person.
std::uint8_t true_label(double u, double v) {
  if (std::abs(u - 175) < 28 && std::abs(v - 125) < 20) return 2;
  const bool is_head = std::hypot(u - 150, v - 45) < 22;
  const bool is_body = std::pow((u - 150) / 45, 4) + std::pow((v - 140) / 80, 4) < 1;
  return is_head || is_body ? 1 : 0;
}

/// `wall`: contrast of its checks, of 255. Noisy, striped, and without the depth of a pixel at each rim, as sensors
/// have it.
Frame scene(std::uint64_t seed, int wall = 0) {
  Random random(seed);
  Frame frame;
  frame.color = ColorImage(kWidth, kHeight, 3);
  frame.depth = DepthImage(kWidth, kHeight);
  frame.labels = LabelImage(kWidth, kHeight);
  constexpr int kColors[3][3] = {{150, 155, 160}, {160, 40, 50}, {60, 120, 70}};
  constexpr double kDepths[3] = {0, 2, 1.7};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const std::uint8_t label = true_label(u, v);
      frame.labels.at(u, v) = label;
      const int stripe = label == 0 ? wall * ((u / 3 + v / 3) % 2) : (u / 6 + v / 9) % 2 * 25;
      for (int c = 0; c < 3; ++c)
        frame.color.at(u, v, c) = static_cast<std::uint8_t>(kColors[label][c] + stripe + 6 * random.normal());
      const bool is_rim =
          true_label(u - 1, v) != label || true_label(u + 1, v) != label || true_label(u, v - 1) != label;
      if (label != 0 && !is_rim) frame.depth.at(u, v) = static_cast<float>(kDepths[label] + 0.005 * random.normal());
    }
  }
  frame.clean_depth = frame.depth;
  return frame;
}

double overlap(const LabelImage& a, const LabelImage& b, std::uint8_t label) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < a.pixel_count(); ++i) {
    both += a.data()[i] == label && b.data()[i] == label ? 1 : 0;
    either += a.data()[i] == label || b.data()[i] == label ? 1 : 0;
  }
  return both / either;
}

/// Each label over what lies within `wider` pixels of it, the highest before the others; less than 0: narrower.
LabelImage resized(const LabelImage& labels, int wider) {
  const int radius = std::abs(wider);
  LabelImage result = labels;
  for (int v = radius; v + radius < kHeight; ++v) {
    for (int u = radius; u + radius < kWidth; ++u) {
      std::uint8_t high = 0;
      bool is_inside = true;
      for (int y = v - radius; y <= v + radius; ++y) {
        for (int x = u - radius; x <= u + radius; ++x) {
          high = std::max(high, labels.at(x, y));
          is_inside = is_inside && labels.at(x, y) == labels.at(u, v);
        }
      }
      result.at(u, v) = wider > 0 ? high : is_inside ? labels.at(u, v) : std::uint8_t{0};
    }
  }
  return result;
}

/// Borders go to and fro by up to three pixels.
LabelImage ragged(const LabelImage& labels) {
  LabelImage result = labels;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int x = u + static_cast<int>(std::lrint(3 * std::sin(0.31 * v + 0.13 * u)));
      const int y = v + static_cast<int>(std::lrint(3 * std::sin(0.27 * u - 0.11 * v)));
      if (labels.contains(x, y)) result.at(u, v) = labels.at(x, y);
    }
  }
  return result;
}

TEST(LabelBorders, ThatAreRightStayAsTheyAre) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Frame frame = scene(seed);
    const Frame given = frame;
    EXPECT_GT(border_contrast(frame.labels, frame.color).value(), 2);
    EXPECT_LE(border_offset(frame.labels, frame.depth).value(), 1);
    EXPECT_FALSE(repair_borders(frame));
    EXPECT_TRUE(std::ranges::equal(frame.labels.values(), given.labels.values()));
    EXPECT_TRUE(std::ranges::equal(frame.depth.values(), given.depth.values()));
  }
}

/// Of the person and of the box with the truth, once the borders of `given` are repaired.
std::array<double, 2> overlaps_after_repair(const LabelImage& given, std::uint64_t seed) {
  Frame frame = scene(seed);
  const LabelImage truth = std::exchange(frame.labels, given);
  EXPECT_LT(border_contrast(frame.labels, frame.color).value(), 1.5);
  EXPECT_TRUE(repair_borders(frame));
  EXPECT_GT(border_contrast(frame.labels, frame.color).value(), 2);
  return {overlap(frame.labels, truth, 1), overlap(frame.labels, truth, 2)};
}

TEST(LabelBorders, ThatAreTooWideTooNarrowOrRaggedAreLaidOnEdges) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const LabelImage truth = scene(seed).labels;
    for (const int wider : {-3, -2, 2, 3}) {
      const auto [person, box] = overlaps_after_repair(resized(truth, wider), seed);
      EXPECT_LT(1 - person, 0.6 * (1 - overlap(resized(truth, wider), truth, 1))) << wider;
      EXPECT_GT(person, 0.91) << wider;
      EXPECT_GT(box, 0.93) << wider;
    }
    const auto [person, box] = overlaps_after_repair(ragged(truth), seed);
    EXPECT_GT(person, overlap(ragged(truth), truth, 1) + 0.02);
    EXPECT_GT(box, 0.9);
  }
}

TEST(LabelBorders, GoAsAWholeToWhereDepthEndsBeforeColoursSayMore) {
  const LabelImage truth = scene(1).labels;
  for (const int wider : {-2, 2}) {
    Frame frame = scene(1, 70);
    frame.labels = resized(truth, wider);
    lay_borders_on_edges(frame);
    EXPECT_GT(overlap(frame.labels, truth, 1), 0.98) << "from " << overlap(resized(truth, wider), truth, 1);
  }
}

TEST(LabelBorders, WhatIsBesideThemHasNoDepth) {
  Frame frame = scene(1);
  for (float& depth : frame.depth.values())
    if (depth == 0) depth = 4; // a wall
  frame.clean_depth = frame.depth;
  frame.labels = resized(frame.labels, 3);
  ASSERT_TRUE(repair_borders(frame));
  for (int v = 1; v < kHeight; ++v) {
    for (int u = 1; u < kWidth; ++u) {
      const bool is_beside = frame.labels.at(u, v) == 0 && frame.labels.at(u - 1, v) != 0;
      if (is_beside) {
        EXPECT_EQ(frame.depth.at(u, v), 0);
        EXPECT_EQ(frame.clean_depth.at(u, v), 0);
      }
    }
  }
  EXPECT_GT(frame.depth.at(5, 5), 0);
}

TEST(LabelBorders, WithoutAnEdgeTheyStay) {
  Frame frame;
  frame.color = ColorImage(kWidth, kHeight, 3);
  std::fill(frame.color.values().begin(), frame.color.values().end(), std::uint8_t{90});
  frame.depth = DepthImage(kWidth, kHeight);
  std::fill(frame.depth.values().begin(), frame.depth.values().end(), 2.0F);
  frame.clean_depth = frame.depth;
  frame.labels = LabelImage(kWidth, kHeight);
  for (int v = 60; v < 180; ++v)
    for (int u = 100; u < 220; ++u) frame.labels.at(u, v) = 1;
  const LabelImage given = frame.labels;
  EXPECT_EQ(border_offset(frame.labels, frame.depth), std::nullopt);
  EXPECT_FALSE(repair_borders(frame));
  lay_borders_on_edges(frame);
  EXPECT_GT(overlap(frame.labels, given, 1), 0.97);
}

TEST(LabelBorders, OfAnyLabelsAndDepthsAreOfTheSameLabels) {
  Random random(3);
  for (int round = 0; round < 40; ++round) {
    Frame frame;
    const int width = 1 + static_cast<int>(random.uniform_double() * 90);
    const int height = 1 + static_cast<int>(random.uniform_double() * 70);
    frame.color = ColorImage(width, height, 3);
    frame.depth = DepthImage(width, height);
    frame.labels = LabelImage(width, height);
    for (std::uint8_t& value : frame.color.values()) value = static_cast<std::uint8_t>(random.uniform_double() * 256);
    for (float& depth : frame.depth.values()) depth = static_cast<float>(std::max(random.uniform_double() - 0.3, 0.0));
    const double cell = 1 + 12 * random.uniform_double();
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u)
        frame.labels.at(u, v) =
            static_cast<std::uint8_t>(static_cast<int>(u / cell) * 7 + static_cast<int>(v / cell) * 5) % 3;
    frame.clean_depth = frame.depth;
    if (round % 4 == 0) std::fill(frame.labels.values().begin(), frame.labels.values().end(), std::uint8_t{255});
    border_contrast(frame.labels, frame.color);
    border_offset(frame.labels, frame.depth);
    lay_borders_on_edges(frame);
    for (const std::uint8_t label : frame.labels.values()) EXPECT_TRUE(label < 3 || (label == 255 && round % 4 == 0));
  }
  Frame unlabelled;
  EXPECT_FALSE(repair_borders(unlabelled));
}

} // namespace
} // namespace kinora::ingest
