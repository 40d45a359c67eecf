#include "ingest/frame/reduced_frame.h"

#include <gtest/gtest.h>

namespace kinora::ingest {
namespace {

constexpr int kFactor = 2;

/// A slanted plane, in inverse depth affine in the pixel, of one colour a column; of 7×5 pixels.
Frame slanted_plane() {
  Frame frame;
  frame.index = 4;
  frame.time = 0.5;
  frame.camera.intrinsics = {7, 5, 10, 11, 3, 2};
  frame.camera.camera_to_world.translation() << 1, 2, 3;
  frame.color = ColorImage(7, 5, 3);
  frame.depth = DepthImage(7, 5);
  for (int v = 0; v < 5; ++v) {
    for (int u = 0; u < 7; ++u) {
      frame.depth.at(u, v) = static_cast<float>(1 + 0.001 * u - 0.002 * v);
      for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = static_cast<std::uint8_t>(10 * u + c);
    }
  }
  frame.clean_depth = frame.depth;
  return frame;
}

TEST(ReducedFrame, ShowsTheSamePlacesInTheSameColours) {
  const Frame frame = slanted_plane();
  const Frame reduced = reduced_frame(frame, kFactor);
  EXPECT_EQ(reduced.index, 4);
  EXPECT_EQ(reduced.time, 0.5);
  EXPECT_EQ(reduced.camera.camera_to_world.matrix(), frame.camera.camera_to_world.matrix());
  ASSERT_EQ(reduced.depth.width(), 3);
  ASSERT_EQ(reduced.depth.height(), 2);
  EXPECT_FALSE(reduced.has_labels());
  for (int v = 0; v < 2; ++v) {
    for (int u = 0; u < 3; ++u) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (int y = 2 * v; y < 2 * v + 2; ++y)
        for (int x = 2 * u; x < 2 * u + 2; ++x)
          mean += 0.25 * frame.camera.intrinsics.unproject(x, y, frame.depth.at(x, y));
      EXPECT_LT((reduced.camera.intrinsics.unproject(u, v, reduced.depth.at(u, v)) - mean).norm(), 1e-4) << u << v;
      EXPECT_EQ(reduced.clean_depth.at(u, v), reduced.depth.at(u, v));
      EXPECT_EQ(reduced.color.at(u, v, 1), 20 * u + 6);
    }
  }
}

TEST(ReducedFrame, DepthIsOfTheLabelThatIsKeptAndOfItsNearestSurface) {
  Frame frame = slanted_plane();
  frame.labels = LabelImage(7, 5);
  frame.depth.at(0, 0) = 0.5F; // another label
  frame.labels.at(1, 1) = frame.labels.at(0, 1) = 2;
  frame.depth.at(0, 1) = 0.9F;
  frame.depth.at(1, 1) = 2.0F; // behind it
  frame.depth.at(2, 0) = frame.depth.at(3, 0) = frame.depth.at(2, 1) = frame.depth.at(3, 1) = 0;
  const Frame reduced = reduced_frame(frame, kFactor);
  EXPECT_EQ(reduced.labels.at(0, 0), 2);
  EXPECT_EQ(reduced.depth.at(0, 0), 0.9F);
  EXPECT_EQ(reduced.labels.at(1, 0), 0);
  EXPECT_EQ(reduced.depth.at(1, 0), 0) << "nothing was measured";
  EXPECT_GT(reduced.clean_depth.at(1, 0), 0);
}

TEST(ReducedFrame, JointsStayOnTheirRays) {
  Frame frame = slanted_plane();
  frame.people.resize(1);
  frame.people[0].joints[3] = {{5, 1}, 0.8};
  const Frame reduced = reduced_frame(frame, kFactor);
  const DetectedJoint& joint = reduced.people.at(0).joints[3];
  const auto ray = [](const Frame& of, const Eigen::Vector2d& pixel) {
    return of.camera.intrinsics.unproject(pixel.x(), pixel.y(), 1);
  };
  EXPECT_LT((ray(reduced, joint.pixel) - ray(frame, frame.people[0].joints[3].pixel)).norm(), 1e-9);
  EXPECT_EQ(joint.score, 0.8);
}

} // namespace
} // namespace kinora::ingest
