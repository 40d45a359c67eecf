// A strip of cloth that comes out from behind a board, bit by bit.
#include "encode/node_births.h"

#include <gtest/gtest.h>

namespace kinora::encode {
namespace {

constexpr int kStrip = 3;
constexpr int kFrames = 20;
constexpr int kWidth = 100, kHeight = 40;
constexpr double kSpacing = 0.1; // metres, of nodes

/// Pixels of the strip from the left up to which a frame shows it.
int shown_up_to(int frame) { return 30 + 3 * frame; }

ingest::Frame picture(int index) {
  ingest::Frame frame;
  frame.index = index;
  frame.color = ColorImage(kWidth, kHeight);
  frame.depth = DepthImage(kWidth, kHeight);
  frame.labels = LabelImage(kWidth, kHeight);
  frame.camera.intrinsics = {kWidth, kHeight, 50, 50, 0, (kHeight - 1) / 2.0};
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const bool strip = v >= 10 && v < 30 && u < 80 && u < shown_up_to(index);
      frame.depth.at(u, v) = strip ? 1.0F : 0.8F;
      frame.labels.at(u, v) = strip ? kStrip : 0;
    }
  }
  frame.clean_depth = frame.depth;
  return frame;
}

/// Nodes along the strip, which is 1.6 m long at 50 pixels for each metre; the last ones are never shown.
motion::Motion motion_of_strip(motion::Health health = motion::Health::kTracked) {
  std::vector<Eigen::Vector3d> nodes;
  nodes.reserve(18);
  for (int i = 0; i < 18; ++i) nodes.emplace_back(kSpacing * i, 0, 1);
  const motion::Motion::Deformation still{
      std::vector<DualQuaternion>(nodes.size(), DualQuaternion::from(SE3::Identity())), health};
  return motion::Motion::deforming(std::make_shared<const motion::DeformationGraph>(nodes, kSpacing, 3 * kSpacing),
                                   std::vector<motion::Motion::Deformation>(kFrames, still));
}

fields::PixelStore store() {
  fields::PixelStore pixels(kFrames * kWidth * kHeight, kFrames);
  for (int f = 0; f < kFrames; ++f) pixels.add(picture(f), f);
  return pixels;
}

/// About when a frame shows a place of the strip first.
double frame_that_shows(double x) { return (50 * x - 30) / 3; }

TEST(NodeBirths, AreWhenSurfaceNearbyIsShownFirst) {
  const fields::PixelStore pixels = store();
  const motion::Motion motion = motion_of_strip();
  const motion::NodeBirths births = node_births({pixels, kStrip, motion}, 0);
  ASSERT_EQ(births.frames().size(), 18U);
  for (std::size_t n = 0; n < 16; ++n) {
    const double shown = frame_that_shows(kSpacing * static_cast<double>(n));
    if (shown < 4) {
      EXPECT_EQ(births.frames()[n], 0U) << n;
    } else if (shown > 8) { // the first few count as the start
      EXPECT_NEAR(births.frames()[n], shown, 3) << n;
    }
  }
  EXPECT_EQ(births.frames()[17], births.frames()[16]) << "with the nearest that was shown";
}

TEST(NodeBirths, AreEarlierWhereNodesThatWereShownHoldThem) {
  const fields::PixelStore pixels = store();
  const motion::Motion motion = motion_of_strip();
  const motion::NodeBirths seen = node_births({pixels, kStrip, motion}, 0);
  const motion::NodeBirths held = node_births({pixels, kStrip, motion}, 3.5 * kSpacing);
  EXPECT_EQ(held.frames()[15], seen.frames()[12]);
  EXPECT_TRUE(node_births({pixels, kStrip, motion}, 2).are_at_the_start());
}

TEST(NodeBirths, OfWhatIsNeverFollowedAreAtTheStart) {
  const fields::PixelStore pixels = store();
  const motion::Motion lost = motion_of_strip(motion::Health::kLost);
  EXPECT_TRUE(node_births({pixels, kStrip, lost}, 0).are_at_the_start());
}

} // namespace
} // namespace kinora::encode
