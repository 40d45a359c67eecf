// A wall with a box before it that a segmenter took for a person; the box keeps still or goes aside.
#include "encode/lost_labels.h"

#include <gtest/gtest.h>

namespace kinora::encode {
namespace {

constexpr int kPerson = 1;
constexpr int kFrames = 10;
constexpr int kWidth = 80, kHeight = 60;

int left_of(bool moves, int frame) { return moves ? 5 + 6 * frame : 30; } // pixels; the box is 12 wide

ingest::Frame picture(int index, bool moves, bool like_the_wall = false) {
  ingest::Frame frame;
  frame.index = index;
  frame.color = ColorImage(kWidth, kHeight);
  frame.depth = DepthImage(kWidth, kHeight);
  frame.labels = LabelImage(kWidth, kHeight);
  frame.camera.intrinsics = {kWidth, kHeight, 60, 60, 39.5, 29.5};
  const int left = left_of(moves, index);
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

TrackedLabel label_with(int number, motion::MotionKind kind, int lost) {
  TrackedLabel label;
  label.plan = {number, number == 0 ? "background" : "person", kind, false, ""};
  label.radius = 0.1;
  if (kind == motion::MotionKind::kStill) return label;
  for (int f = 0; f < kFrames; ++f) {
    SE3 pose = SE3::Identity();
    pose.translation().x() = 0.1 * f;
    label.poses.push_back({pose, f >= kFrames - lost ? motion::Health::kLost : motion::Health::kTracked});
  }
  return label;
}

FramePass pass_with(bool moves, int lost) {
  FramePass pass{{}, fields::PixelStore(kFrames * kWidth * kHeight, kFrames), {}, {}, 0};
  for (int f = 0; f < kFrames; ++f) pass.pixels.add(picture(f, moves), f);
  pass.labels[0] = label_with(0, motion::MotionKind::kStill, 0);
  pass.labels[kPerson] = label_with(kPerson, motion::MotionKind::kRigid, lost);
  return pass;
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
  EXPECT_EQ(still_share(pass_with(false, 0).pixels, kPerson), 1);
  EXPECT_LT(still_share(pass_with(true, 0).pixels, kPerson), 0.2);
  EXPECT_EQ(still_share(pass_with(false, 0).pixels, 7), 0);
}

TEST(StillShare, CountsWhatIsSeenBehindInTheSameColour) {
  fields::PixelStore pixels(kFrames * kWidth * kHeight, kFrames);
  for (int f = 0; f < kFrames; ++f) pixels.add(picture(f, true, true), f);
  EXPECT_EQ(still_share(pixels, kPerson), 1);
}

TEST(LostLabels, AreTheRoomsWhereTheyKeepStill) {
  FramePass pass = pass_with(false, 6);
  const auto dropped = drop_lost_labels(pass, segmented());
  ASSERT_EQ(dropped.size(), 1U);
  EXPECT_EQ(dropped[0].label, kPerson);
  EXPECT_NE(dropped[0].why.find("the background has it"), std::string::npos) << dropped[0].why;
  EXPECT_FALSE(pass.labels.contains(kPerson));
  EXPECT_EQ(pixels_of(pass.pixels, kPerson), 0U);
  EXPECT_EQ(pixels_of(pass.pixels, 0), pass.pixels.pixels().size());
}

TEST(LostLabels, AreTrainedOnNowhereWhereTheyMove) {
  FramePass pass = pass_with(true, 6);
  const std::size_t before = pixels_of(pass.pixels, kPerson);
  const auto dropped = drop_lost_labels(pass, segmented());
  ASSERT_EQ(dropped.size(), 1U);
  EXPECT_NE(dropped[0].why.find("nothing is made of it"), std::string::npos) << dropped[0].why;
  EXPECT_FALSE(pass.labels.contains(kPerson));
  EXPECT_EQ(pixels_of(pass.pixels, kPerson), before);
}

TEST(LostLabels, StayWhereMostFramesAreFollowed) {
  FramePass pass = pass_with(false, 5);
  EXPECT_TRUE(drop_lost_labels(pass, segmented()).empty());
  EXPECT_TRUE(pass.labels.contains(kPerson));
}

TEST(LostLabels, StayWhereAMaskSaysThatTheyAreThere) {
  FramePass pass = pass_with(false, 9);
  EXPECT_TRUE(drop_lost_labels(pass, {}).empty());
  EXPECT_TRUE(pass.labels.contains(kPerson));
}

} // namespace
} // namespace kinora::encode
