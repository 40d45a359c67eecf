// A wall with a box before it that a segmenter took for a person; the box keeps still or goes aside.
#include "encode/unfounded_labels.h"

#include <functional>

#include <gtest/gtest.h>

namespace kinora::encode {
namespace {

constexpr int kPerson = 1;
constexpr int kFrames = 10;
constexpr int kWidth = 80, kHeight = 60;
constexpr double kFocal = 60;
constexpr double kBoxDepth = 1.5;

// Where the box's left edge is in a frame, or should be: pixels. It is 12 wide.
using Path = std::function<int(int frame)>;

int keeps_still(int) { return 30; }
int goes_aside(int frame) { return 5 + 6 * frame; }
int goes_aside_late(int frame) { return frame < kFrames - 3 ? 30 : 50; }
int wavers(int frame) { return 30 + 3 * (frame % 3); }

ingest::Frame picture(int index, const Path& path, bool like_the_wall = false) {
  ingest::Frame frame;
  frame.index = index;
  frame.color = ColorImage(kWidth, kHeight);
  frame.depth = DepthImage(kWidth, kHeight);
  frame.labels = LabelImage(kWidth, kHeight);
  frame.camera.intrinsics = {kWidth, kHeight, 60, 60, 39.5, 29.5};
  const int left = path(index);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const bool box = u >= left && u < left + 12 && v >= 20 && v < 40;
      frame.depth.at(u, v) = box ? 1.5F : 2.5F;
      frame.labels.at(u, v) = box ? kPerson : 0;
      frame.color.pixel(u, v)[0] = box && !like_the_wall ? 200 : 100;
    }
  }
  frame.clean_depth = frame.depth;
  return frame;
}

TrackedLabel label_with(int number, motion::MotionKind kind, const Path& tracked, int lost) {
  TrackedLabel label;
  label.plan = {number, number == 0 ? "background" : "person", kind, false, ""};
  label.radius = 0.1;
  if (kind == motion::MotionKind::kStill) return label;
  for (int f = 0; f < kFrames; ++f) {
    SE3 pose = SE3::Identity();
    pose.translation().x() = (tracked(f) - tracked(0)) * kBoxDepth / kFocal;
    label.poses.push_back({pose, f >= kFrames - lost ? motion::Health::kLost : motion::Health::kTracked});
  }
  return label;
}

fields::PixelStore store_of(const Path& path, bool like_the_wall = false, double share = 1) {
  fields::PixelStore pixels(static_cast<std::size_t>(share * kFrames * kWidth * kHeight), kFrames);
  for (int f = 0; f < kFrames; ++f) pixels.add(picture(f, path, like_the_wall), f);
  return pixels;
}

/// The box goes one way, and is tracked as if it went another; it is lost in the last frames.
FramePass pass_with(const Path& path, const Path& tracked, int lost) {
  FramePass pass{{}, store_of(path), {}, {}, 0};
  pass.clip.times.resize(kFrames);
  pass.labels[0] = label_with(0, motion::MotionKind::kStill, keeps_still, 0);
  pass.labels[kPerson] = label_with(kPerson, motion::MotionKind::kRigid, tracked, lost);
  return pass;
}

MotionGain gain_of(const Path& path, const Path& tracked, double share = 1) {
  const TrackedLabel label = label_with(kPerson, motion::MotionKind::kRigid, tracked, 0);
  return motion_gain(store_of(path, false, share), kPerson, label.motion(), kFrames);
}

ingest::CaptureInfo segmented() {
  ingest::CaptureInfo info;
  info.labels[kPerson] = {"person", "rigid", "what moves"};
  return info;
}

std::size_t pixels_of(const fields::PixelStore& store, int label) {
  std::size_t count = 0;
  for (const auto& pixel : store.pixels()) count += pixel.label == label ? 1 : 0;
  return count;
}

TEST(StillShare, IsOneForWhatKeepsStillAndNoneForWhatGoesAside) {
  EXPECT_EQ(still_share(store_of(keeps_still), kPerson), 1);
  EXPECT_LT(still_share(store_of(goes_aside), kPerson), 0.2);
  EXPECT_EQ(still_share(store_of(keeps_still), 7), 0);
}

TEST(StillShare, CountsWhatIsSeenBehindInTheSameColour) {
  EXPECT_EQ(still_share(store_of(goes_aside, true), kPerson), 1);
}

TEST(MotionGain, IsAllWhereMotionIsTrueAndRestIsNot) {
  const MotionGain gain = gain_of(goes_aside, goes_aside);
  EXPECT_GT(gain.told, 1000);
  EXPECT_EQ(gain.by_motion, gain.told);
  EXPECT_LT(gain.at_rest, gain.told / 2);
  EXPECT_TRUE(gain.pays());
}

TEST(MotionGain, PaysWhereAThingGoesAsideLateAndNotWhereItIsToldToWaver) {
  const MotionGain late = gain_of(goes_aside_late, goes_aside_late);
  EXPECT_GT(late.at_rest, late.told / 2);
  EXPECT_TRUE(late.pays());
  EXPECT_FALSE(gain_of(keeps_still, wavers).pays());
  EXPECT_FALSE(gain_of(goes_aside_late, wavers).pays());
}

TEST(MotionGain, IsTheSameShareOfLooksWhereFewPixelsAreKept) {
  const MotionGain all = gain_of(goes_aside_late, goes_aside_late);
  const MotionGain some = gain_of(goes_aside_late, goes_aside_late, 0.4);
  const auto share = [](const MotionGain& gain) { return (gain.by_motion - gain.at_rest) / gain.looks; };
  EXPECT_NEAR(share(some), share(all), 0.2 * share(all));
}

TEST(MotionGain, DoesNotPayWhereTheRoomSeemsToMoveAsMuch) {
  MotionGain gain{1000, 800, 650, 780, 0, 0};
  EXPECT_TRUE(gain.pays());
  gain.room_told = 500;
  gain.room_at_rest = 460; // rest fails at 8 %, and at 19 % of the label
  EXPECT_TRUE(gain.pays());
  gain.room_at_rest = 450;
  EXPECT_FALSE(gain.pays());
}

TEST(MotionGain, AsksTheRoomOnlyFromElsewhere) {
  const auto room_told = [](double metres_a_frame) {
    fields::PixelStore pixels(kFrames * kWidth * kHeight, kFrames);
    for (int f = 0; f < kFrames; ++f) {
      ingest::Frame frame = picture(f, goes_aside);
      frame.camera.camera_to_world.translation().x() = metres_a_frame * f;
      pixels.add(frame, f);
    }
    const TrackedLabel label = label_with(kPerson, motion::MotionKind::kRigid, goes_aside, 0);
    return motion_gain(pixels, kPerson, label.motion(), kFrames).room_told;
  };
  EXPECT_EQ(room_told(0), 0);
  EXPECT_GT(room_told(0.01), 1000);
}

TEST(MotionGain, IsNotAskedWhereNothingTells) { EXPECT_TRUE(MotionGain{}.pays()); }

TEST(UnfoundedLabels, AreTheRoomsWhereTheyKeepStill) {
  for (const int lost : {0, 6}) { // not followed, or followed to no avail
    FramePass pass = pass_with(keeps_still, wavers, lost);
    const auto dropped = drop_unfounded_labels(pass, segmented());
    ASSERT_EQ(dropped.size(), 1U) << lost;
    EXPECT_EQ(dropped[0].label, kPerson);
    EXPECT_NE(dropped[0].why.find(lost > 0 ? "followed in fewer than half" : "no better than if it kept still"),
              std::string::npos)
        << dropped[0].why;
    EXPECT_NE(dropped[0].why.find("the background has it"), std::string::npos) << dropped[0].why;
    EXPECT_FALSE(pass.labels.contains(kPerson));
    EXPECT_EQ(pixels_of(pass.pixels, kPerson), 0U);
    EXPECT_EQ(pixels_of(pass.pixels, 0), pass.pixels.pixels().size());
  }
}

TEST(UnfoundedLabels, AreThoseThatAreOnlyHeldToo) {
  FramePass pass = pass_with(goes_aside, goes_aside, 6);
  for (motion::Motion::Pose& pose : pass.labels[kPerson].poses) {
    if (pose.health == motion::Health::kLost) pose.health = motion::Health::kHeld;
  }
  EXPECT_EQ(drop_unfounded_labels(pass, segmented()).size(), 1U);
}

TEST(UnfoundedLabels, AreTrainedOnNowhereWhereTheyMove) {
  FramePass pass = pass_with(goes_aside, goes_aside, 6);
  const std::size_t before = pixels_of(pass.pixels, kPerson);
  const auto dropped = drop_unfounded_labels(pass, segmented());
  ASSERT_EQ(dropped.size(), 1U);
  EXPECT_NE(dropped[0].why.find("nothing is made of it"), std::string::npos) << dropped[0].why;
  EXPECT_FALSE(pass.labels.contains(kPerson));
  EXPECT_EQ(pixels_of(pass.pixels, kPerson), before);
}

TEST(UnfoundedLabels, AreNoneWhereMostFramesAreFollowedAndExplained) {
  FramePass pass = pass_with(goes_aside, goes_aside, 5);
  EXPECT_TRUE(drop_unfounded_labels(pass, segmented()).empty());
  EXPECT_TRUE(pass.labels.contains(kPerson));
}

TEST(UnfoundedLabels, AreNoneWhereAMaskSaysThatTheyAreThere) {
  FramePass pass = pass_with(keeps_still, wavers, 9);
  EXPECT_TRUE(drop_unfounded_labels(pass, {}).empty());
  EXPECT_TRUE(pass.labels.contains(kPerson));
}

} // namespace
} // namespace kinora::encode
