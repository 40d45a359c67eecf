// Surfaces go on where colour was seen and no depth.
#include <gtest/gtest.h>

#include "core/random.h"
#include "fields/sampling/surface_extension.h"

namespace kinora::fields {
namespace {

constexpr int kWidth = 80;
constexpr int kHeight = 60;
constexpr std::array<std::uint8_t, 3> kWhite = {230, 230, 225};
constexpr std::array<std::uint8_t, 3> kBrown = {90, 60, 30};

struct Seen {
  float depth;
  std::array<std::uint8_t, 3> color;
};

/// What `seen(u, v)` tells of each pixel, or of the place of so many times as many; nothing was measured where
/// `missing(u, v)`.
template <class SeenAt, class Missing>
ingest::Frame frame_of(const SeenAt& seen, const Missing& missing, int times = 1) {
  ingest::Frame frame;
  const int width = times * kWidth, height = times * kHeight;
  frame.camera.intrinsics = {width, height, 70.0 * times, 70.0 * times, 40.0 * times, 30.0 * times};
  frame.color = ColorImage(width, height, 3);
  frame.clean_depth = DepthImage(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Seen at = seen(u, v);
      std::copy(at.color.begin(), at.color.end(), frame.color.pixel(u, v));
      if (!missing(u, v)) frame.clean_depth.at(u, v) = at.depth;
    }
  }
  frame.depth = frame.clean_depth;
  return frame;
}

/// A table top that comes nearer towards the lower edge: 0.4 m of height below the camera, from 3 m on a wall.
Seen table(int /*u*/, int v) {
  const float below = static_cast<float>(v - 20) / 70; // by how much the ray sinks for each metre
  return {below > 0 ? std::min(3.0F, 0.4F / below) : 3.0F, kWhite};
}

TEST(ExtendSurfaces, ATableGoesOnAsAPlaneToTheBorder) {
  const ingest::Frame frame = frame_of(table, [](int u, int v) { return v >= 45 || u < 5; });
  const DepthImage guessed = extend_surfaces(frame, 0);
  for (int v = 36; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      if (frame.clean_depth.at(u, v) > 0) {
        EXPECT_EQ(guessed.at(u, v), 0) << "measured at " << u << ", " << v;
      } else {
        EXPECT_NEAR(guessed.at(u, v), table(u, v).depth, 0.02F * table(u, v).depth) << u << ", " << v;
      }
    }
  }
}

// 1280×960: cells of 4×4 pixels.
TEST(ExtendSurfaces, InALargePictureCellsGoOn) {
  constexpr int kTimes = 16;
  const auto seen = [](int u, int v) {
    const float below = (static_cast<float>(v) / kTimes - 20) / 70;
    return Seen{below > 0 ? std::min(3.0F, 0.4F / below) : 3.0F, u < 640 ? kWhite : kBrown};
  };
  const auto is_missing = [](int u, int v) { return v >= 45 * kTimes + 2 || (u == 401 && v == 401); };
  const ingest::Frame frame = frame_of(seen, is_missing, kTimes);
  const DepthImage guessed = extend_surfaces(frame, 0);
  EXPECT_EQ(guessed.at(401, 401), 0) << "its cell has measured pixels";
  for (int v = 36 * kTimes; v < frame.color.height(); ++v) {
    for (int u = 0; u < frame.color.width(); ++u) {
      if (v < 45 * kTimes + 4) { // the cells of the edge have measured pixels
        ASSERT_EQ(guessed.at(u, v), 0) << u << ", " << v;
      } else {
        ASSERT_NEAR(guessed.at(u, v), seen(u, v).depth, 0.02F * seen(u, v).depth) << u << ", " << v;
      }
    }
  }
}

TEST(ExtendSurfaces, TheShadowBesideAThingBelongsToTheWallThatItLooksLike) {
  const auto seen = [](int u, int v) {
    const bool thing = u >= 30 && u < 50 && v >= 20 && v < 40;
    return thing ? Seen{0.8F, kBrown} : Seen{2, kWhite};
  };
  const auto is_shadow = [](int u, int v) { return u >= 20 && u < 30 && v >= 20 && v < 40; };
  const DepthImage guessed = extend_surfaces(frame_of(seen, is_shadow), 0);
  for (int u = 20; u < 29; ++u) EXPECT_NEAR(guessed.at(u, 30), 2, 0.05F) << u; // 29 is on the edge
}

TEST(ExtendSurfaces, AHoleThatShowsTwoThingsIsDividedWhereTheColourChanges) {
  const auto seen = [](int u, int) { return u < 40 ? Seen{1, kBrown} : Seen{2, kWhite}; };
  const DepthImage guessed = extend_surfaces(frame_of(seen, [](int u, int) { return u >= 25 && u < 45; }), 0);
  for (int u = 25; u < 39; ++u) EXPECT_NEAR(guessed.at(u, 30), 1, 0.02F) << u;
  for (int u = 41; u < 45; ++u) EXPECT_NEAR(guessed.at(u, 30), 2, 0.02F) << u;
}

TEST(ExtendSurfaces, OnlyPixelsWithTheLabelTellAndAreTold) {
  ingest::Frame frame = frame_of(
      [](int u, int) {
        return Seen{u < 40 ? 1.0F : 2.0F, kWhite};
      },
      [](int u, int) { return u >= 40 && u < 60; });
  frame.labels = LabelImage(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < 45; ++u) frame.labels.at(u, v) = 1;
  }
  const DepthImage guessed = extend_surfaces(frame, 0);
  for (int u = 0; u < 45; ++u) EXPECT_EQ(guessed.at(u, 30), 0) << u;
  for (int u = 45; u < 60; ++u) EXPECT_NEAR(guessed.at(u, 30), 2, 0.02F) << "not from what has another label, " << u;
}

TEST(ExtendSurfaces, WithoutAnyDepthNothingIsGuessed) {
  const DepthImage guessed = extend_surfaces(frame_of(table, [](int, int) { return true; }), 0);
  for (const float depth : guessed.values()) EXPECT_EQ(depth, 0);
}

// Slopes that would lead behind the camera or to infinity stay near what the frame shows; every hole is filled.
TEST(ExtendSurfaces, WhateverIsMeasuredGuessesStayInItsRange) {
  Random random(7, 0);
  for (int round = 0; round < 20; ++round) {
    const float slope = 0.1F * (random.uniform() - 0.5F);
    const float noise = 0.3F * random.uniform();
    const float share = random.uniform();
    float nearest = 1e9F, farthest = 0;
    const auto seen = [&](int u, int v) {
      const float depth = std::max(0.3F, 2 + slope * static_cast<float>(u + v) + noise * (random.uniform() - 0.5F));
      const auto level = static_cast<std::uint8_t>(random.below(256));
      return Seen{depth, {level, level, level}};
    };
    const ingest::Frame frame = frame_of(seen, [&](int u, int) { return random.uniform() < share || u > 50; });
    for (const float depth : frame.clean_depth.values()) {
      if (depth > 0) nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
    }
    const DepthImage guessed = extend_surfaces(frame, 0);
    for (std::size_t i = 0; i < guessed.pixel_count(); ++i) {
      if (frame.clean_depth.data()[i] > 0 || farthest == 0) {
        ASSERT_EQ(guessed.data()[i], 0);
      } else {
        ASSERT_GE(guessed.data()[i], nearest / 2.1F) << "round " << round;
        ASSERT_LE(guessed.data()[i], farthest * 2.1F) << "round " << round;
      }
    }
  }
}

TEST(ExtendSurfaces, HolesOfWhichNothingIsWantedChangeNothingElse) {
  const auto is_missing = [](int u, int v) {
    return (u >= 10 && u < 14 && v >= 10 && v < 14) || (u == 14 && v == 14) || u >= 60; // one, by a corner, and a strip
  };
  const ingest::Frame frame = frame_of(table, is_missing);
  const DepthImage all = extend_surfaces(frame, 0);
  const DepthImage strip = extend_surfaces(frame, 0, [](int u, int v) { return u == 79 && v == 0; });
  const DepthImage spot = extend_surfaces(frame, 0, [](int u, int v) { return u == 14 && v == 14; });
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      EXPECT_EQ(strip.at(u, v), u >= 60 ? all.at(u, v) : 0) << u << ", " << v;
      EXPECT_EQ(spot.at(u, v), u < 60 ? all.at(u, v) : 0) << u << ", " << v;
    }
  }
  EXPECT_GT(all.at(12, 12), 0);
}

} // namespace
} // namespace kinora::fields
