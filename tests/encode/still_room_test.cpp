// A wall, a plate before it that moves, and a hole in the wall's depth.
#include "encode/still_room.h"

#include <functional>

#include <gtest/gtest.h>

namespace kinora::encode {
namespace {

constexpr int kWidth = 160, kHeight = 120, kFrames = 16;
constexpr float kWall = 2.5F, kPlate = 1.5F;

/// What one pixel shows in one frame.
struct Shown {
  float depth = kWall;
  int label = 0;
};
using Scene = std::function<Shown(int frame, int u, int v)>;

/// A plate of 20 by 20 pixels that goes from left to right, in the upper half; two frames show it at each place.
bool is_plate(int frame, int u, int v) {
  const int left = 10 + 8 * (frame / 2);
  return u >= left && u < left + 20 && v >= 20 && v < 40;
}

Shown plate_before_wall(int frame, int u, int v) { return is_plate(frame, u, v) ? Shown{kPlate, 2} : Shown{}; }

fields::PixelStore stored(const Scene& scene, double camera_step = 0) {
  fields::PixelStore pixels(std::size_t{kFrames} * kWidth * kHeight, kFrames);
  for (int f = 0; f < kFrames; ++f) {
    ingest::Frame frame;
    frame.index = f;
    frame.color = ColorImage(kWidth, kHeight);
    frame.depth = DepthImage(kWidth, kHeight);
    frame.labels = LabelImage(kWidth, kHeight);
    frame.camera.intrinsics = {kWidth, kHeight, 120, 120, 79.5, 59.5};
    frame.camera.camera_to_world = SE3(Eigen::Translation3d(camera_step * f, 0, 0));
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const Shown shown = scene(f, u, v);
        frame.depth.at(u, v) = shown.depth;
        frame.labels.at(u, v) = static_cast<std::uint8_t>(shown.label);
      }
    }
    frame.clean_depth = frame.depth;
    pixels.add(frame, f);
  }
  return pixels;
}

const fields::StoredPixel& pixel_at(const fields::PixelStore& pixels, int frame, int u, int v) {
  const std::size_t row = static_cast<std::size_t>(frame) * kHeight + static_cast<std::size_t>(v);
  return pixels.pixels()[row * kWidth + static_cast<std::size_t>(u)];
}

bool equal(const fields::PixelStore& a, const fields::PixelStore& b) {
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    const fields::StoredPixel& p = a.pixels()[i];
    const fields::StoredPixel& q = b.pixels()[i];
    if (p.label != q.label || p.depth.metres() != q.depth.metres() || p.depth.is_measured() != q.depth.is_measured()) {
      return false;
    }
  }
  return true;
}

/// All about the hole is nearer than the plate that passes before it: what goes on from there would hide the plate.
Shown hole_amid_near_things(int frame, int u, int v) {
  if (is_plate(frame, u, v)) return {kPlate, 2};
  return {u > 20 && u < 140 && v > 10 && v < 110 ? 0 : 1.2F, 0};
}

TEST(StillRoom, GuessesLieBehindWhatPassesBeforeThem) {
  fields::PixelStore pixels = stored(hole_amid_near_things);
  const float guessed_before = pixel_at(pixels, 0, 80, 30).depth.metres();
  ASSERT_TRUE(pixel_at(pixels, 0, 80, 30).depth.is_extended());
  ASSERT_LT(guessed_before, kPlate);
  correct_still_room(pixels);
  EXPECT_GT(pixel_at(pixels, 0, 80, 30).depth.metres(), kPlate + 0.04F);
  EXPECT_LT(pixel_at(pixels, 0, 80, 30).depth.metres(), kPlate + 0.2F);
  EXPECT_TRUE(pixel_at(pixels, 0, 80, 30).depth.is_extended());
  EXPECT_GT(pixel_at(pixels, 0, 70, 41).depth.metres(), kPlate + 0.04F) << "beside its way";
  EXPECT_NEAR(pixel_at(pixels, 0, 80, 90).depth.metres(), guessed_before, 0.01F) << "where nothing ever passed";
}

TEST(StillRoom, GuessesLieWhereOtherFramesMeasureTheRoom) {
  fields::PixelStore pixels = stored([](int frame, int u, int v) {
    const Shown shown = hole_amid_near_things(frame, u, v);
    return shown.depth == 0 && frame >= 9 ? Shown{} : shown; // the wall is measured in the last frames
  });
  correct_still_room(pixels);
  EXPECT_NEAR(pixel_at(pixels, 0, 80, 30).depth.metres(), kWall, 0.001F);
}

TEST(StillRoom, WhatIsBeforeTheRoomIsNotTheRooms) {
  const auto is_mislabelled = [](int frame, int u, int v) { return is_plate(frame, u, v) && v >= 38; };
  fields::PixelStore pixels = stored([&](int frame, int u, int v) {
    return is_mislabelled(frame, u, v) ? Shown{kPlate, 0} : plate_before_wall(frame, u, v);
  });
  correct_still_room(pixels);
  for (int f = 0; f < kFrames; ++f) {
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const fields::StoredPixel& pixel = pixel_at(pixels, f, u, v);
        const int wanted = is_mislabelled(f, u, v) ? 255 : is_plate(f, u, v) ? 2 : 0;
        ASSERT_EQ(pixel.label, wanted) << "at " << u << ", " << v << " of frame " << f;
        ASSERT_EQ(pixel.depth.metres(), is_plate(f, u, v) ? kPlate : kWall);
      }
    }
  }
}

TEST(StillRoom, EdgesOfWhatRestsStay) {
  const Scene flickers = [](int frame, int u, int v) { // far from the plate
    return v >= 80 && v < 84 && frame % 3 == 0 ? Shown{1.8F, 0} : plate_before_wall(frame, u, v);
  };
  fields::PixelStore pixels = stored(flickers);
  correct_still_room(pixels);
  EXPECT_TRUE(equal(pixels, stored(flickers)));
}

TEST(StillRoom, ALabelOfTheCapturesIsNotTaken) {
  fields::PixelStore pixels = stored([](int frame, int u, int v) {
    if (!is_plate(frame, u, v)) return Shown{};
    return Shown{kPlate, v < 30 ? 255 : v < 38 ? 2 : 0};
  });
  correct_still_room(pixels);
  EXPECT_EQ(pixel_at(pixels, 0, 20, 25).label, 255);
  EXPECT_EQ(pixel_at(pixels, 0, 20, 38).label, 254);
}

TEST(StillRoom, NothingIsSaidFromAMovingCamera) {
  fields::PixelStore pixels = stored(hole_amid_near_things, 0.01);
  correct_still_room(pixels);
  EXPECT_TRUE(equal(pixels, stored(hole_amid_near_things, 0.01)));
}

TEST(StillRoom, NoFramesAreNothingToCorrect) {
  fields::PixelStore pixels(100, 1);
  correct_still_room(pixels);
  EXPECT_TRUE(pixels.frames().empty());
}

} // namespace
} // namespace kinora::encode
