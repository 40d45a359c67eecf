// Pictures that are turned into those of a rolling shutter, beside ones whose rows are drawn one by one.
#include "fields/rendering/row_by_row.h"

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "fields/scenes/drawn_scene.h"

namespace kinora::fields {
namespace {

using testing::camera_at;
using testing::kBox;
using testing::Paint;
using testing::painted_field;

/// A wall with waves behind a ball.
Paint ball_before_wall(const Eigen::Vector3d& at) {
  const double ball = (at - Eigen::Vector3d(0.05, 0, 0.1)).norm() - 0.2;
  const double wall = at.z() + 0.35;
  const double wave = 0.5 + 0.4 * std::sin(25 * at.x()) * std::cos(25 * at.y());
  return ball < wall ? Paint{ball, {wave, 0.2, 0.3}} : Paint{wall, {0.2, wave, 1 - wave}};
}

struct View {
  DrawableField field{painted_field(kBox, ball_before_wall)};
  Camera camera = camera_at({0.1, 0.1, 1.1}, {0, 0, 0});

  Picture from(const SE3& camera_to_world) const {
    const PosedField posed{&field};
    Camera moved = camera;
    moved.camera_to_world = camera_to_world;
    return render({&posed, 1}, moved, {.normals = true, .confidence = false});
  }
  Picture row_after_row(const Twist& readout) const {
    Picture out = from(camera.camera_to_world);
    for (int v = 0; v < camera.intrinsics.height; ++v) {
      const Picture at = from(camera.camera_to_world * exp_se3(row_time(v, camera.intrinsics.height) * readout));
      for (int u = 0; u < camera.intrinsics.width; ++u) {
        std::copy_n(at.color.pixel(u, v), 4, out.color.pixel(u, v));
        std::copy_n(at.normal.pixel(u, v), 3, out.normal.pixel(u, v));
        out.depth.at(u, v) = at.depth.at(u, v);
        out.front.at(u, v) = at.front.at(u, v);
      }
    }
    return out;
  }
};

struct Difference {
  double color = 0, depth = 0, normal = 0; ///< means over the picture
};

Difference between(const Picture& a, const Picture& b) {
  Difference sum;
  const auto pixels = static_cast<double>(a.color.pixel_count());
  for (int v = 0; v < a.color.height(); ++v) {
    for (int u = 0; u < a.color.width(); ++u) {
      for (int c = 0; c < 4; ++c) sum.color += std::abs(a.color.at(u, v, c) - b.color.at(u, v, c)) / pixels / 4;
      for (int c = 0; c < 3; ++c) {
        sum.normal += static_cast<double>(std::abs(a.normal.at(u, v, c) - b.normal.at(u, v, c))) / pixels;
      }
      sum.depth += static_cast<double>(std::abs(a.depth.at(u, v) - b.depth.at(u, v))) / pixels;
    }
  }
  return sum;
}

TEST(ReadRowByRow, ShowsWhatEachRowsOwnCameraSees) {
  const View view;
  const Picture at_once = view.from(view.camera.camera_to_world);
  for (const Twist& readout : {(Twist() << 0.4, 0, 0, 0, 0, 0).finished(), (Twist() << 0, 0, 0, 0.2, 0.4, 0).finished(),
                               (Twist() << 0.1, -0.1, 0.2, -0.15, 0.2, 0.3).finished()}) {
    const Picture truth = view.row_after_row(readout);
    const Difference before = between(at_once, truth);
    const Difference after = between(read_row_by_row(at_once, view.camera.intrinsics, readout, readout), truth);
    EXPECT_LT(after.color, 0.4 * before.color) << readout.transpose();
    EXPECT_LT(after.depth, 0.6 * before.depth) << readout.transpose(); // looked up in whole pixels
    EXPECT_LT(after.normal, 0.6 * before.normal) << readout.transpose();
  }
}

TEST(ReadRowByRow, ReadsDepthForItself) {
  const View view;
  const Picture at_once = view.from(view.camera.camera_to_world);
  const Twist readout = (Twist() << 0.1, -0.1, 0.2, -0.15, 0.2, 0.3).finished();
  const Picture color = read_row_by_row(at_once, view.camera.intrinsics, readout, Twist::Zero());
  const Picture depth = read_row_by_row(at_once, view.camera.intrinsics, Twist::Zero(), readout);
  const Picture both = read_row_by_row(at_once, view.camera.intrinsics, readout, readout);
  EXPECT_LT(between(color, at_once).depth, 1e-6);
  EXPECT_GT(between(color, at_once).color, 1);
  EXPECT_LT(between(color, both).color, 1e-9);
  EXPECT_LT(between(depth, at_once).color, 1e-9);
  EXPECT_LT(between(depth, both).depth, 1e-6);
}

TEST(ReadRowByRow, OfACameraThatDoesNotMoveIsThePictureItself) {
  const View view;
  const Picture picture = view.from(view.camera.camera_to_world);
  const Picture same = read_row_by_row(picture, view.camera.intrinsics, Twist::Zero(), Twist::Zero());
  const Difference difference = between(picture, same);
  EXPECT_LT(difference.color, 1e-9);
  EXPECT_LT(difference.depth, 1e-6);
  EXPECT_LT(difference.normal, 1e-6);
  EXPECT_TRUE(same.confidence.empty());
}

TEST(ReadRowByRow, StaysInThePictureHoweverTheCameraMoves) {
  const View view;
  const Picture picture = view.from(view.camera.camera_to_world);
  for (const double size : {1.0, 10.0, 1e6}) {
    const Picture out = read_row_by_row(picture, view.camera.intrinsics, Twist::Constant(size), Twist::Constant(-size));
    EXPECT_TRUE(out.color.same_size(picture.color));
    for (const float depth : out.depth.values()) ASSERT_TRUE(std::isfinite(depth));
  }
}

} // namespace
} // namespace kinora::fields
