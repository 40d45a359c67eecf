// Pictures of what moves over one of all that does not are the same to the bit as without.
#include <algorithm>

#include <gtest/gtest.h>

#include "fields/rendering/renderer.h"
#include "fields/scenes/drawn_scene.h"

namespace kinora::fields {
namespace {

using testing::camera_at;
using testing::kBox;
using testing::Paint;
using testing::painted_field;
using testing::PaintedBall;

void expect_equal(const Picture& a, const Picture& b) {
  EXPECT_TRUE(std::ranges::equal(a.color.values(), b.color.values()));
  EXPECT_TRUE(std::ranges::equal(a.depth.values(), b.depth.values()));
  EXPECT_TRUE(std::ranges::equal(a.front.values(), b.front.values()));
  EXPECT_TRUE(std::ranges::equal(a.normal.values(), b.normal.values()));
  EXPECT_TRUE(std::ranges::equal(a.confidence.values(), b.confidence.values()));
}

/// A wall and a ball that stay, a ball that goes and a sheet that bends.
class BackdropTest : public ::testing::Test {
protected:
  static Paint wall(const Eigen::Vector3d& point) {
    const double stripes = 0.5 + 0.5 * std::sin(25 * point.x()) * std::cos(19 * point.y());
    return {0.3 - point.z(), {stripes, 1 - stripes, 0.4}};
  }
  static Paint sheet(const Eigen::Vector3d& point) {
    const double outside = std::max({std::abs(point.x()) - 0.2, std::abs(point.y()) - 0.3, std::abs(point.z()) - 0.03});
    return {outside, {0.9, 0.5 + point.y(), 0.2}};
  }

  std::vector<PosedField> posed_at(double seconds) const {
    SE3 aside = SE3::Identity();
    aside.translate(Eigen::Vector3d(0.5 - seconds, 0.1 * seconds, -0.2));
    std::vector<DualQuaternion> nodes;
    for (const Eigen::Vector3d& node : graph_->nodes()) {
      SE3 rotation = SE3::Identity();
      rotation.rotate(Eigen::AngleAxisd(2 * seconds * node.y(), Eigen::Vector3d::UnitY()));
      nodes.push_back(DualQuaternion::from(rotation));
    }
    return {pose(ball_, motion::Warp(aside)),
            {&wall_, SE3::Identity()},
            pose(sheet_, motion::Warp(graph_, nodes)),
            {&post_, SE3::Identity()}};
  }
  /// Of the layers that stay.
  Backdrop backdrop(const Camera& camera, const DrawOptions& options, Picture& picture) const {
    const auto all = posed_at(0);
    picture = render(std::vector<PosedField>{all[1], all[3]}, camera, options);
    return {&picture, {1, 3}};
  }

  std::shared_ptr<const motion::DeformationGraph> graph_ = testing::graph_of_box();
  DrawableField wall_{painted_field(kBox, wall)};
  DrawableField post_{painted_field(kBox, PaintedBall{{0.25, 0.1, 0}, 0.12})};
  DrawableField ball_{painted_field(kBox, PaintedBall{{0, 0, 0}, 0.15})};
  DrawableField sheet_{painted_field(kBox, sheet), graph_.get()};
};

TEST_F(BackdropTest, ChangesNoBitOfAnyPicture) {
  for (const Eigen::Vector3d& position : {Eigen::Vector3d(0, 0, -1.5), Eigen::Vector3d(0.8, 0.4, -0.9),
                                          Eigen::Vector3d(0.1, -0.1, -0.4), Eigen::Vector3d(0.02, 0.01, 0.01)}) {
    const Camera camera = camera_at(position, {0, 0, 0.3}, 131, 97);
    for (const int samples : {1, 2}) {
      for (const Unseen unseen : {Unseen::kKeep, Unseen::kFade}) {
        DrawOptions options;
        options.samples = samples;
        options.unseen = unseen;
        options.normals = options.confidence = samples == 1;
        Picture still;
        const Backdrop behind = backdrop(camera, options, still);
        for (const double seconds : {0.0, 0.3, 0.7}) {
          SCOPED_TRACE(::testing::Message()
                       << position.transpose() << ", " << samples << " samples, " << seconds << " s");
          const auto layers = posed_at(seconds);
          expect_equal(render(layers, camera, options, &behind), render(layers, camera, options));
        }
      }
    }
  }
}

TEST_F(BackdropTest, IsTakenWhereNothingElseIsNear) {
  const Camera camera = camera_at({0, 0, -1.5}, {0, 0, 0.3});
  Picture painted;
  const Backdrop behind = backdrop(camera, {}, painted);
  std::ranges::fill(painted.color.values(), std::uint8_t{7});
  const auto layers = posed_at(0.3);
  const Picture picture = render(layers, camera, {}, &behind);
  int taken = 0, drawn = 0;
  for (int v = 0; v < picture.color.height(); ++v) {
    for (int u = 0; u < picture.color.width(); ++u) {
      const bool moving = picture.front.at(u, v) == 1 || picture.front.at(u, v) == 3;
      const bool from_backdrop = picture.color.at(u, v, 3) == 7;
      EXPECT_FALSE(moving && from_backdrop);
      taken += from_backdrop ? 1 : 0;
      drawn += moving ? 1 : 0;
    }
  }
  EXPECT_GT(drawn, 300);
  EXPECT_GT(taken, 2000);
}

TEST_F(BackdropTest, AloneIsThePicture) {
  const Camera camera = camera_at({0, 0, -1.5}, {0, 0, 0.3});
  Picture still;
  Backdrop behind = backdrop(camera, {}, still);
  const auto all = posed_at(0);
  behind.layers = {0, 1};
  expect_equal(render(std::vector<PosedField>{all[1], all[3]}, camera, {}, &behind), still);
}

} // namespace
} // namespace kinora::fields
