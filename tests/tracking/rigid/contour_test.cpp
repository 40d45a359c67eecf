#include "tracking/rigid/contour.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tracking/scenes/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;
using testing::render_frame;
using testing::SceneOptions;

LayerView view_of(const SE3& object_to_camera, const SceneOptions& options = {}) {
  return view_label(render_frame({}, object_to_camera, SE3::Identity(), 0, options), 2);
}

TEST(ContourOf, PointsOutOfTheLayerAtItsDepth) {
  const LayerView view = view_of(pose_at({0.05, -0.03, 0.8}, 20, 30));
  const std::vector<ContourPoint> contour = contour_of(view);
  ASSERT_GT(contour.size(), 150U);
  for (const ContourPoint& point : contour) {
    const Eigen::Vector2d pixel = view.intrinsics.project(point.position);
    const Eigen::Vector2d beyond = pixel + 3 * point.normal;
    EXPECT_EQ(view.mask.at(static_cast<int>(std::lround(beyond.x())), static_cast<int>(std::lround(beyond.y()))), 0);
    EXPECT_NEAR(point.position.z(), 0.8, 0.17);
    EXPECT_NEAR(point.normal.norm(), 1, 1e-12);
  }
}

TEST(ContourOf, LeavesOutWhatSomethingNearerHides) {
  SceneOptions options;
  options.occluded_columns = 120;
  const LayerView view = view_of(pose_at({0, 0, 0.8}, 0, 0), options);
  const std::vector<ContourPoint> contour = contour_of(view);
  ASSERT_GT(contour.size(), 50U);
  for (const ContourPoint& point : contour) EXPECT_GT(point.normal.x(), -0.9) << "the cut is no rim";
}

TEST(ContourOf, IsEmptyWithoutALayer) {
  EXPECT_TRUE(contour_of(LayerView()).empty());
  EXPECT_TRUE(ContourMap(LayerView()).empty());
}

TEST(ContourMap, MeasuresHowFarARimHasMoved) {
  const LayerView before = view_of(pose_at({0, 0, 0.8}, 0, 0));
  const LayerView after = view_of(pose_at({0.01, 0, 0.8}, 0, 0)); // by 3.3 pixels, rounded to 3 or 4
  const ContourMap map(after);
  double right = 0;
  double left = 0;
  double count_right = 0;
  double count_left = 0;
  for (const ContourPoint& point : contour_of(before)) {
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

TEST(ContourMap, ResidualHasTheJacobianOfItsValue) {
  const SE3 pose = pose_at({0.05, -0.03, 0.8}, 20, 30);
  const LayerView view = view_of(pose);
  const ContourMap map(view_of(pose_at({0.055, -0.03, 0.8}, 20, 30)));
  const Pivot pivot{view.centroid, 0.1};
  constexpr double kStep = 1e-6; // metres; far below a pixel, so that the nearest one stays
  std::size_t checked = 0;
  for (const ContourPoint& point : contour_of(view)) {
    const auto here = map.residual(point, view, pivot, 6);
    if (!here) continue;
    for (int i = 0; i < 6; ++i) {
      const auto value_after = [&](double step) {
        ContourPoint moved = point;
        moved.position = step_about(pivot, step * Twist::Unit(i), SE3::Identity()) * point.position;
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

// Two views of one rod: what its depth and its outline are wrong by in one has nothing to do with the other.
TEST(ContourMap, JacobianAndCounterpartHaveIndependentErrors) {
  const auto view_of_rod = [](std::uint64_t seed) {
    SceneOptions options;
    options.noise = 1;
    options.seed = seed;
    const testing::Shape rod{testing::ShapeKind::kCylinder, {0.1, 2, 0}, false};
    return view_label(render_frame(rod, pose_at({0, 0, 1.8}, 0, 0), SE3::Identity(), 0, options), 2);
  };
  constexpr int kTurn = 4; // about the rod's axis: by the depth of its limb, which is alike all along it
  std::vector<Eigen::Vector2d> pairs;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const LayerView after = view_of_rod(2 * seed + 1);
    const ContourMap map(after);
    for (const ContourPoint& point : contour_of(view_of_rod(2 * seed))) {
      const auto r = map.residual(point, after, Pivot{{0, 0, 1.8}, 0.1}, 4);
      if (r && point.normal.x() > 0.95) pairs.emplace_back(r->jacobian[kTurn], r->counterpart[kTurn]);
    }
  }
  ASSERT_GT(pairs.size(), 500U);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& pair : pairs) mean += pair / static_cast<double>(pairs.size());
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& pair : pairs) covariance += (pair - mean) * (pair - mean).transpose();
  EXPECT_LT(std::abs(covariance(0, 1)), 0.2 * std::sqrt(covariance(0, 0) * covariance(1, 1)));
}

} // namespace
} // namespace kinora::tracking
