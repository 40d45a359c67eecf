#include "tracking/rigid/rigid_icp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tracking/rigid/point_selection.h"
#include "tracking/rigid/pose_quality.h"
#include "tracking/scenes/synthetic_scene.h"

namespace kinora::tracking {
namespace {

using testing::pose_at;
using testing::render_frame;
using testing::Shape;
using testing::ShapeKind;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr Gates kGates{0.05, 0.7};

/// A model fused from one frame, and the pose it was seen at.
struct Model {
  std::vector<SurfacePoint> surface;
  SE3 model_to_camera;
  LayerView view;
};

Model model_of(const Shape& shape, const SE3& object_to_camera) {
  Model model;
  model.view = view_label(render_frame(shape, object_to_camera, SE3::Identity(), 0), 2);
  model.model_to_camera = object_to_camera;
  TsdfVolume volume({0.005, 0.025, 64}, Eigen::Vector3d::Zero());
  volume.integrate(model.view.planes, model.view.texture, model.view.intrinsics, object_to_camera.inverse());
  model.surface = volume.surface_points();
  return model;
}

Twist unit(int i) { return Twist::Unit(i); }

// The largest difference between analytic and numeric derivative over the points, relative to the largest derivative.
template <class ResidualAt>
double jacobian_error(const std::vector<ModelPoint>& points, const Model& model, const Pivot& pivot, double step,
                      const ResidualAt& residual_at, std::size_t& checked) {
  double worst = 0;
  double largest = 0;
  for (const ModelPoint& point : points) {
    const std::optional<Residual> here = residual_at(point, model.model_to_camera);
    if (!here) continue;
    for (int i = 0; i < 6; ++i) {
      const auto ahead = residual_at(point, step_about(pivot, step * unit(i), model.model_to_camera));
      const auto behind = residual_at(point, step_about(pivot, -step * unit(i), model.model_to_camera));
      if (!ahead || !behind) continue;
      const double numeric = (ahead->value - behind->value) / (2 * step);
      worst = std::max(worst, std::abs(numeric - here->jacobian[i]));
      largest = std::max(largest, std::abs(numeric));
      ++checked;
    }
  }
  return worst / largest;
}

TEST(GeometricResidual, HasTheJacobianOfItsValue) {
  const Model model = model_of({}, pose_at({0.05, -0.03, 0.8}, 20, 30));
  const std::vector<ModelPoint> points = select_points(model.surface, model.view, model.model_to_camera, 300);
  const Pivot pivot{model.view.centroid, 0.1};
  std::size_t checked = 0;
  // A step far below a pixel keeps the measured point; derivatives at a pixel's border are the few that do not.
  const auto residual_at = [&](const ModelPoint& point, const SE3& pose) -> std::optional<Residual> {
    const Eigen::Vector2d pixel = model.view.intrinsics.project(pose * point.position.cast<double>());
    const Eigen::Vector2d from_centre = pixel.array() - (pixel.array() + 0.5).floor();
    if (from_centre.cwiseAbs().maxCoeff() > 0.49) return std::nullopt;
    const auto projected = project(point, model.view, pose);
    return projected ? geometric_residual(*projected, model.view, pivot, kGates) : std::nullopt;
  };
  EXPECT_LT(jacobian_error(points, model, pivot, 1e-7, residual_at, checked), 1e-5);
  EXPECT_GT(checked, 300U);
}

TEST(PhotometricResidual, HasTheJacobianOfItsValueUpToTheImagesInterpolation) {
  const Model model = model_of({}, pose_at({0.05, -0.03, 0.8}, 20, 30));
  const std::vector<ModelPoint> points = select_points(model.surface, model.view, model.model_to_camera, 300);
  const Pivot pivot{model.view.centroid, 0.1};
  std::size_t checked = 0;
  const auto residual_at = [&](const ModelPoint& point, const SE3& pose) -> std::optional<Residual> {
    const auto projected = project(point, model.view, pose);
    return projected ? photometric_residual(*projected, point, model.view, pivot, 0) : std::nullopt;
  };
  EXPECT_LT(jacobian_error(points, model, pivot, 0.002, residual_at, checked), 0.2);
  EXPECT_GT(checked, 300U);
}

TEST(PhotometricResidual, IsNotTakenThroughAnOccluder) {
  const Model model = model_of({}, pose_at({0, 0, 0.8}, 20, 30));
  LayerView hidden = model.view;
  for (float& z : hidden.depth.values()) z = 0.5F;
  const std::vector<ModelPoint> points = select_points(model.surface, model.view, model.model_to_camera, 300);
  ASSERT_FALSE(points.empty());
  for (const ModelPoint& point : points) {
    const auto projected = project(point, hidden, model.model_to_camera);
    EXPECT_FALSE(projected && photometric_residual(*projected, point, hidden, Pivot(), 0));
  }
}

TEST(StepAbout, KeepsThePivotInPlaceWhenItOnlyTurns) {
  const Pivot pivot{{0.1, 0.2, 1.3}, 0.1};
  const SE3 pose = pose_at({0, 0, 1}, 10, 20);
  Twist rotation = Twist::Zero();
  rotation[4] = 0.05;
  const SE3 moved = step_about(pivot, rotation, pose) * pose.inverse();
  EXPECT_TRUE((moved * pivot.centre).isApprox(pivot.centre, 1e-12));
  EXPECT_NEAR(rotation_angle(moved), 0.5, 1e-12);
}

TEST(Align, FindsABoxThatMovedByFiveCentimetresAndFifteenDegrees) {
  const SE3 first = pose_at({0, 0, 0.9}, 25, 30);
  const Model model = model_of({}, first);
  const SE3 truth = Eigen::Translation3d(0.03, -0.02, 0.03) * pose_at({0, 0, 0.9}, 20, 42, 6);
  const LayerView view = view_label(render_frame({}, truth, SE3::Identity(), 1), 2);
  const auto points = select_points(model.surface, view, first, 2000);
  const Alignment found = align(points, view, first, first);
  EXPECT_LT((found.model_to_camera.translation() - truth.translation()).norm(), 0.001);
  EXPECT_LT(rotation_angle(found.model_to_camera.inverse() * truth), 0.01);
  EXPECT_EQ(found.degenerate_directions, 0);
}

struct Degenerate {
  const char* name;
  Shape shape;
  int open; ///< directions that depth alone leaves open
};

class AlignDegenerate : public ::testing::TestWithParam<Degenerate> {};

TEST_P(AlignDegenerate, NamesWeakDirectionsAndKeepsThemAtThePrior) {
  const SE3 first = pose_at({0, 0, 0.8}, 0, 0);
  const Shape shape = GetParam().shape;
  const Model model = model_of(shape, first);
  testing::SceneOptions options;
  options.noise = 1;
  const LayerView view = view_label(render_frame(shape, pose_at({0, 0, 0.81}, 0, 0), SE3::Identity(), 1, options), 2);
  const auto points = select_points(model.surface, view, first, 1500);
  const Alignment found = align(points, view, first, first);
  EXPECT_EQ(found.degenerate_directions, GetParam().open);
  EXPECT_TRUE(found.model_to_camera.matrix().allFinite());
  EXPECT_NEAR(found.model_to_camera.translation().z(), 0.81, 0.001);
  EXPECT_LT(found.model_to_camera.translation().head<2>().norm(), 0.003);
  EXPECT_LT(rotation_angle(found.model_to_camera), 0.03);
}

INSTANTIATE_TEST_SUITE_P(Shapes, AlignDegenerate,
                         ::testing::Values(Degenerate{"plane", {ShapeKind::kPlane, {0, 0, 0}, false}, 3},
                                           Degenerate{"sphere", {ShapeKind::kSphere, {0.12, 0, 0}, false}, 3},
                                           Degenerate{"cylinder", {ShapeKind::kCylinder, {0.1, 2, 0}, false}, 2}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Align, FollowsTheTextureWhereAPlaneWouldSlide) {
  constexpr int kDirections = 16;
  const Shape plane{ShapeKind::kPlane, {0, 0, 0}, true};
  const SE3 first = pose_at({0, 0, 0.803}, 2, 3);
  const Model model = model_of(plane, first);
  std::vector<double> shifts;
  std::vector<double> rotations;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    const SE3 truth = pose_at({0.007 * std::cos(angle), 0.007 * std::sin(angle), 0.803}, 2, 3, 1);
    const LayerView view = view_label(render_frame(plane, truth, SE3::Identity(), 1), 2);
    const Alignment found = align(select_points(model.surface, view, first, 3000), view, first, first);
    EXPECT_EQ(found.degenerate_directions, 0) << k;
    shifts.push_back((found.model_to_camera.translation() - truth.translation()).norm());
    rotations.push_back(rotation_angle(found.model_to_camera.inverse() * truth));
  }
  std::sort(shifts.begin(), shifts.end());
  std::sort(rotations.begin(), rotations.end());
  EXPECT_LT(shifts[kDirections / 2], 1e-4);
  EXPECT_LT(rotations[kDirections / 2], 1e-3);
  // Points that come and go at the picture's border hold up a third of them before the last step.
  EXPECT_LT(shifts.back(), 0.002);
  EXPECT_LT(rotations.back(), 0.01);
}

TEST(Align, IsNotMisledByAChangeOfLight) {
  const SE3 first = pose_at({0, 0, 0.9}, 25, 30);
  const Model model = model_of({}, first);
  testing::SceneOptions options;
  options.light = 0.6;
  const SE3 truth = pose_at({0.01, 0, 0.9}, 25, 33);
  const LayerView view = view_label(render_frame({}, truth, SE3::Identity(), 1, options), 2);
  const Alignment found = align(select_points(model.surface, view, first, 2000), view, first, first);
  EXPECT_LT((found.model_to_camera.translation() - truth.translation()).norm(), 0.001);
  EXPECT_LT(rotation_angle(found.model_to_camera.inverse() * truth), 0.01);
}

TEST(Align, ReturnsThePriorWithoutPointsOrView) {
  const SE3 prior = pose_at({1, 2, 3}, 10, 20);
  const Alignment nothing = align({}, LayerView(), SE3::Identity(), prior);
  EXPECT_TRUE(nothing.model_to_camera.isApprox(prior));
  EXPECT_EQ(nothing.degenerate_directions, 6);
}

TEST(SolveWithPrior, TakesTheNewtonStepWhereTheSystemIsStrong) {
  Random random(7);
  Matrix6 root;
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = random.normal();
  const Matrix6 information = root * root.transpose() + Matrix6::Identity();
  const Twist gradient = Twist::LinSpaced(-1, 1);
  const DampedStep solved = solve_with_prior(information, information, gradient, Twist::Ones(), 1e-6, 0);
  EXPECT_EQ(solved.degenerate_directions, 0);
  EXPECT_TRUE((information * solved.step).isApprox(-gradient, 1e-9));
}

TEST(SolveWithPrior, GivesTheOpenDirectionsOfARankDeficientSystemToThePrior) {
  Matrix6 information = Matrix6::Zero();
  information(2, 2) = 100;
  Twist gradient = Twist::Zero();
  gradient[2] = -50;
  const Twist prior = Twist::Constant(0.25);
  const DampedStep solved = solve_with_prior(information, information, gradient, prior, 1, 0);
  EXPECT_EQ(solved.degenerate_directions, 5);
  Twist expected = prior;
  expected[2] = 0.5;
  EXPECT_TRUE(solved.step.isApprox(expected, 1e-12));
}

TEST(SolveWithPrior, FollowsThePriorAloneWhenTheSystemIsEmpty) {
  const Twist prior = Twist::Constant(0.25);
  const DampedStep solved = solve_with_prior(Matrix6::Zero(), Matrix6::Zero(), Twist::Zero(), prior, 1, 1e-3);
  EXPECT_EQ(solved.degenerate_directions, 6);
  EXPECT_TRUE(solved.step.isApprox(prior, 1e-12));
}

TEST(JudgePose, TellsTheRightPoseFromAWrongOne) {
  const SE3 truth = pose_at({0, 0, 0.9}, 25, 30);
  const Model model = model_of({}, truth);
  const auto points = select_points(model.surface, model.view, truth, 2000);
  const PoseQuality right = evaluate_pose(points, model.view, truth);
  const PoseQuality wrong = evaluate_pose(points, model.view, Eigen::Translation3d(0.02, 0.01, 0.02) * truth);
  EXPECT_GT(right.inlier_share(), 0.95);
  EXPECT_GT(right.texture_correlation, 0.95);
  EXPECT_LT(wrong.inlier_share(), 0.5);
  EXPECT_LT(wrong.texture_correlation, 0.5);
}

} // namespace
} // namespace kinora::tracking
