// A wall with a box before it that comes late, leaves, hides behind a board or goes on unlabelled.
#include "encode/layer_presence.h"

#include <functional>

#include <gtest/gtest.h>

namespace kinora::encode {
namespace {

using motion::FrameSpan;
using motion::Health;

constexpr int kBox = 2;
constexpr int kFrames = 20;
constexpr int kWidth = 80, kHeight = 60;

/// What stands before the wall in a frame.
struct Shown {
  bool box = true;
  bool labelled = true;
  bool board = false; ///< before the box
};

/// The box is to be seen from frame 8 to 11 at least.
struct Scene {
  std::function<Shown(int)> shows;
  motion::MotionKind kind = motion::MotionKind::kRigid;
  std::function<Health(int)> health = [](int frame) {
    return frame < 8 ? Health::kLost : frame < 12 ? Health::kTracked : Health::kHeld;
  };
};

ingest::Frame picture(int index, const Shown& shown) {
  ingest::Frame frame;
  frame.index = index;
  frame.color = ColorImage(kWidth, kHeight);
  frame.depth = DepthImage(kWidth, kHeight);
  frame.labels = LabelImage(kWidth, kHeight);
  frame.camera.intrinsics = {kWidth, kHeight, 60, 60, 39.5, 29.5};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const bool box = shown.box && u >= 30 && u < 42 && v >= 20 && v < 40;
      frame.depth.at(u, v) = shown.board ? 1.0F : box ? 1.5F : 2.5F;
      frame.labels.at(u, v) = box && shown.labelled && !shown.board ? kBox : 0;
    }
  }
  frame.clean_depth = frame.depth;
  return frame;
}

std::vector<FrameSpan> away(const Scene& scene) {
  fields::PixelStore pixels(kFrames * kWidth * kHeight, kFrames);
  TrackedLabel label;
  label.plan = {kBox, "box", scene.kind, false, ""};
  label.first_shown = kFrames;
  std::vector<motion::Motion::Pose> poses;
  for (int f = 0; f < kFrames; ++f) {
    const Shown shown = scene.shows(f);
    pixels.add(picture(f, shown), f);
    poses.push_back({SE3::Identity(), scene.health(f)});
    if (!shown.box || !shown.labelled || shown.board) continue;
    label.first_shown = std::min(label.first_shown, static_cast<std::size_t>(f));
    label.last_shown = static_cast<std::size_t>(f);
  }
  const bool still = scene.kind == motion::MotionKind::kStill;
  const motion::Motion motion = still ? motion::Motion::still() : motion::Motion::rigid(std::move(poses));
  return layer_presence(label, motion, pixels, kFrames).away();
}

Shown only_in_the_middle(int frame) { return {frame >= 8 && frame < 12}; }

TEST(LayerPresence, EndsWhereTheRoomIsSeenThroughIt) {
  EXPECT_EQ(away({only_in_the_middle}), (std::vector<FrameSpan>{{0, 5}, {15, 20}}));
  EXPECT_EQ(away({only_in_the_middle, motion::MotionKind::kStill}), (std::vector<FrameSpan>{{0, 5}, {15, 20}}));
}

TEST(LayerPresence, OfWhatIsAlwaysSeenIsAlways) {
  EXPECT_TRUE(away({[](int) { return Shown{}; }}).empty());
}

TEST(LayerPresence, GoesOnBehindWhatHidesIt) {
  EXPECT_TRUE(away({[](int frame) { return Shown{true, true, frame < 8 || frame >= 12}; }}).empty());
}

TEST(LayerPresence, GoesOnWhereOnlyTheLabelsEnd) {
  EXPECT_TRUE(away({[](int frame) { return Shown{true, frame >= 8 && frame < 12}; }}).empty());
}

TEST(LayerPresence, GoesOnWhereItIsTracked) {
  EXPECT_TRUE(away({only_in_the_middle, motion::MotionKind::kRigid, [](int) { return Health::kTracked; }}).empty());
}

TEST(LayerPresence, IsNotInterruptedInBetween) {
  EXPECT_TRUE(away({[](int frame) { return Shown{frame < 4 || frame >= 16}; }, motion::MotionKind::kRigid,
                    [](int frame) { return frame < 4 || frame >= 16 ? Health::kTracked : Health::kLost; }})
                  .empty());
}

} // namespace
} // namespace kinora::encode
