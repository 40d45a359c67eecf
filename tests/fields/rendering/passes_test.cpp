// What a picture says beside colour and depth.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/drawn_scene.h"
#include "fields/scenes/normal_error.h"

namespace kinora::fields {
namespace {

using testing::camera_at;
using testing::graph_of_box;
using testing::kBox;
using testing::normal_error;
using testing::NormalError;
using testing::painted_field;
using testing::PaintedBall;

Picture with_normals(const PosedField& posed, const Camera& camera) {
  return render({&posed, 1}, camera, {.normals = true});
}

TEST(Normals, OfABallAreWithinDegreesOfTheTruthFromAllSidesAndInAnyPose) {
  const PaintedBall ball;
  const DrawableField field(painted_field(kBox, ball));
  SE3 canonical_to_world = SE3::Identity();
  canonical_to_world.rotate(Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, 3).normalized()));
  canonical_to_world.pretranslate(Eigen::Vector3d(3, -7, 10));
  for (int i = 0; i < 6; ++i) {
    const double a = 2 * std::numbers::pi * i / 6;
    const Eigen::Vector3d centre = canonical_to_world.translation();
    const Camera camera = camera_at(centre + Eigen::Vector3d(1.1 * std::sin(a), 0.5, 1.1 * std::cos(a)), centre);
    const NormalError error =
        normal_error(with_normals({&field, canonical_to_world}, camera), camera,
                     [&](const auto& point) { return Eigen::Vector3d((point - centre).normalized()); });
    EXPECT_LT(error.mean, 2.5);
    EXPECT_LT(error.worst, 8);
  }
}

// Stretched along the vertical: turning the canonical normals alone would be 20 degrees off.
TEST(Normals, OfALayerThatDeformsFollowTheInverseTransposeOfItsMotion) {
  constexpr double kStretch = 1.5;
  const auto graph = graph_of_box();
  const PaintedBall ball{{0, 0, 0}, 0.25};
  const DrawableField field(painted_field(kBox, ball), graph.get());
  std::vector<DualQuaternion> nodes;
  for (const Eigen::Vector3d& node : graph->nodes()) {
    nodes.push_back(DualQuaternion::from(SE3(Eigen::Translation3d(0, (kStretch - 1) * node.y(), 0))));
  }
  const motion::Warp warp(graph, nodes);
  const Camera camera = camera_at({0.3, 0.4, -1.1}, {0, 0, 0}, 192, 144);
  const NormalError error = normal_error(with_normals(pose(field, warp), camera), camera, [&](const auto& point) {
    const auto found = warp.to_canonical(point);
    if (!found) return Eigen::Vector3d(0, 0, 0);
    const Eigen::Vector3d& canonical = *found;
    Eigen::Matrix3d jacobian;
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d step = 1e-3 * Eigen::Vector3d::Unit(a);
      jacobian.col(a) = 500 * (warp.to_world(canonical + step).value() - warp.to_world(canonical - step).value());
    }
    return Eigen::Vector3d(jacobian.inverse().transpose() * canonical).normalized();
  });
  EXPECT_LT(error.mean, 5);
}

TEST(Normals, AreDrawnOnlyForThoseWhoAsk) {
  const DrawableField field(painted_field(kBox, PaintedBall{}));
  const PosedField posed{&field};
  const Camera camera = camera_at({0, 0, -1.2}, {0, 0, 0});
  const Picture plain = render({&posed, 1}, camera);
  const Picture asked = with_normals(posed, camera);
  EXPECT_TRUE(plain.normal.empty());
  EXPECT_TRUE(std::ranges::equal(plain.color.values(), asked.color.values()));
  EXPECT_TRUE(std::ranges::equal(plain.depth.values(), asked.depth.values()));
}

TEST(Normals, SameBitsForAnyNumberOfThreads) {
  const DrawableField field(painted_field(kBox, PaintedBall{}));
  const Camera camera = camera_at({0.4, 0.3, -1.0}, {0, 0, 0});
  set_thread_count(1);
  const Picture one = with_normals({&field}, camera);
  set_thread_count(7);
  const Picture seven = with_normals({&field}, camera);
  set_thread_count(0);
  EXPECT_TRUE(std::ranges::equal(one.normal.values(), seven.normal.values()));
}

} // namespace
} // namespace kinora::fields
