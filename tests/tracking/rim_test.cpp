#include "tracking/rim.h"

#include <gtest/gtest.h>

#include "tracking/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;
using testing::render_frame;
using testing::SceneOptions;

ObjectView view_of(const SE3& object_to_camera, const SceneOptions& options = {}) {
  return view_object(render_frame({}, object_to_camera, SE3::Identity(), 0, options), 2);
}

TEST(RimOf, PointsOutOfTheLayerAtItsDepth) {
  const ObjectView view = view_of(pose_at({0.05, -0.03, 0.8}, 20, 30));
  const std::vector<RimPoint> rim = rim_of(view);
  ASSERT_GT(rim.size(), 150U);
  for (const RimPoint& point : rim) {
    const Eigen::Vector2d pixel = view.intrinsics.project(point.place);
    const Eigen::Vector2d beyond = pixel + 3 * point.normal;
    EXPECT_EQ(view.mask.at(static_cast<int>(std::lround(beyond.x())), static_cast<int>(std::lround(beyond.y()))), 0);
    EXPECT_NEAR(point.place.z(), 0.8, 0.17);
    EXPECT_NEAR(point.normal.norm(), 1, 1e-12);
  }
}

TEST(RimOf, LeavesOutWhatSomethingNearerHides) {
  SceneOptions options;
  options.occluded_columns = 120;
  const ObjectView view = view_of(pose_at({0, 0, 0.8}, 0, 0), options);
  const std::vector<RimPoint> rim = rim_of(view);
  ASSERT_GT(rim.size(), 50U);
  for (const RimPoint& point : rim) EXPECT_GT(point.normal.x(), -0.9) << "the cut is no rim";
}

TEST(RimOf, IsEmptyWithoutALayer) {
  EXPECT_TRUE(rim_of(ObjectView()).empty());
  EXPECT_TRUE(RimMap(ObjectView()).empty());
}

TEST(RimMap, MeasuresHowFarARimHasMoved) {
  const ObjectView before = view_of(pose_at({0, 0, 0.8}, 0, 0));
  const ObjectView after = view_of(pose_at({0.01, 0, 0.8}, 0, 0)); // by 3.3 pixels, rounded to 3 or 4
  const RimMap map(after);
  double right = 0;
  double left = 0;
  double count_right = 0;
  double count_left = 0;
  for (const RimPoint& point : rim_of(before)) {
    const auto r = map.residual(point, after, Pivot(), 8);
    if (!r || std::abs(point.normal.x()) < 0.95) continue;
    (point.normal.x() > 0 ? right : left) += r->value;
    (point.normal.x() > 0 ? count_right : count_left) += 1;
  }
  ASSERT_GT(count_right, 20);
  ASSERT_GT(count_left, 20);
  EXPECT_NEAR(right / count_right, -3.3, 1);
  EXPECT_NEAR(left / count_left, 3.3, 1);
}

TEST(RimMap, ResidualHasTheJacobianOfItsValue) {
  const SE3 pose = pose_at({0.05, -0.03, 0.8}, 20, 30);
  const ObjectView view = view_of(pose);
  const RimMap map(view_of(pose_at({0.055, -0.03, 0.8}, 20, 30)));
  const Pivot pivot{view.centroid, 0.1};
  constexpr double kStep = 1e-6; // metres; far below a pixel, so that the nearest one stays
  std::size_t checked = 0;
  for (const RimPoint& point : rim_of(view)) {
    const auto here = map.residual(point, view, pivot, 6);
    if (!here) continue;
    for (int i = 0; i < 6; ++i) {
      const auto value_after = [&](double step) {
        RimPoint moved = point;
        moved.place = step_about(pivot, step * Twist::Unit(i), SE3::Identity()) * point.place;
        return map.residual(moved, view, pivot, 6);
      };
      const auto ahead = value_after(kStep);
      const auto behind = value_after(-kStep);
      if (!ahead || !behind || std::abs(ahead->value - behind->value) > 0.1) continue; // another pixel is nearest
      EXPECT_NEAR((ahead->value - behind->value) / (2 * kStep), here->jacobian[i], 1e-3 * here->jacobian.norm());
      ++checked;
    }
  }
  EXPECT_GT(checked, 500U);
}

} // namespace
} // namespace kinora::tracking
