// What is drawn of fields whose shape is known exactly, from any camera.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "fields/rendering/projected_layer.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/drawn_scene.h"

namespace kinora::fields {
namespace {

using testing::camera_at;
using testing::graph_of_box;
using testing::kBox;
using testing::kCell;
using testing::painted_field;
using testing::PaintedBall;

struct BallError {
  double depth = 0;   ///< metres, mean over pixels that both have
  double color = 0;   ///< mean over the same
  double overlap = 0; ///< of the silhouettes
};

BallError compare_ball(const Picture& picture, const Camera& camera, const PaintedBall& ball,
                       const SE3& ball_to_world) {
  BallError error;
  int both = 0, either = 0;
  const SE3 ball_from_camera = ball_to_world.inverse() * camera.camera_to_world;
  for (int v = 0; v < picture.depth.height(); ++v) {
    for (int u = 0; u < picture.depth.width(); ++u) {
      const Eigen::Vector3d direction = ball_from_camera.linear() * camera.intrinsics.unproject(u, v, 1);
      const double truth = ball.depth_of(ball_from_camera.translation(), direction);
      const float drawn = picture.depth.at(u, v);
      either += truth > 0 || drawn > 0 ? 1 : 0;
      if (truth <= 0 || drawn <= 0) continue;
      ++both;
      error.depth += std::abs(drawn - truth);
      const Eigen::Vector3d color = ball(ball_from_camera.translation() + truth * direction).color;
      for (int c = 0; c < 3; ++c) {
        const double expected = 1 / (1 + std::exp(4 - 8 * color[c]));
        error.color += std::abs(picture.color.at(u, v, c) / 255.0 - expected) / 3;
      }
    }
  }
  error.depth /= both;
  error.color /= both;
  error.overlap = static_cast<double>(both) / either;
  return error;
}

std::size_t drawn_pixels(const Picture& picture) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.color.pixel_count(); ++i) count += picture.color.data()[4 * i + 3] > 127 ? 1 : 0;
  return count;
}

/// Over all channels.
double psnr(const Picture& a, const Picture& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.color.values().size(); ++i) {
    const double difference = static_cast<double>(a.color.data()[i]) - b.color.data()[i];
    sum += difference * difference;
  }
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(a.color.values().size()) / std::max(sum, 1e-6));
}

Picture draw(const DrawableField& field, const Camera& camera, const SE3& pose = SE3::Identity(),
             DrawQuality quality = DrawQuality::kFull) {
  const PosedField posed{&field, pose};
  return render({&posed, 1}, camera, {quality});
}

TEST(Drawing, ABallFromAllSides) {
  const PaintedBall ball;
  const DrawableField field(painted_field(kBox, ball));
  for (int i = 0; i < 12; ++i) {
    const double a = 2 * std::numbers::pi * i / 12;
    Camera camera = camera_at({1.1 * std::sin(a), 0.7 * std::sin(2 * a), 1.1 * std::cos(a)}, {0, 0, 0});
    for (const DrawQuality quality : {DrawQuality::kFull, DrawQuality::kFast}) {
      if (quality == DrawQuality::kFast) { // as good as full quality at half the size
        camera.intrinsics = camera.intrinsics.resized(2 * camera.intrinsics.width, 2 * camera.intrinsics.height);
      }
      const BallError error =
          compare_ball(draw(field, camera, SE3::Identity(), quality), camera, ball, SE3::Identity());
      EXPECT_LT(error.depth, (quality == DrawQuality::kFull ? 0.8 : 1.2) * kCell) << "camera " << i;
      EXPECT_LT(error.color, 0.03) << "camera " << i;
      EXPECT_GT(error.overlap, 0.95) << "camera " << i;
    }
  }
}

TEST(Drawing, PosesCarryALayerAlsoAKilometreAway) {
  const PaintedBall ball;
  const DrawableField field(painted_field(kBox, ball));
  const Camera near = camera_at({0.2, 0.3, -1.2}, {0, 0, 0});
  const Picture here = draw(field, near);
  SE3 far = SE3::Identity();
  far.rotate(Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, 3).normalized()));
  far.pretranslate(Eigen::Vector3d(1000, -700, 1000));
  Camera moved = near;
  moved.camera_to_world = far * near.camera_to_world;
  const Picture there = draw(field, moved, far);
  EXPECT_GT(psnr(there, here), 45);
  EXPECT_EQ(drawn_pixels(here), drawn_pixels(there));
}

TEST(Drawing, CamerasInsideBehindAndLookingAway) {
  const DrawableField field(painted_field(kBox, PaintedBall{}));
  // Inside the ball everything is opaque at once.
  const Picture inside = draw(field, camera_at({0.05, 0.02, 0}, {0.3, 0.1, 1}));
  EXPECT_EQ(drawn_pixels(inside), inside.color.pixel_count());
  // Within the hull, but outside of the ball.
  const Picture close = draw(field, camera_at({0, 0, -0.31}, {0, 0, 0}));
  EXPECT_EQ(drawn_pixels(close), close.color.pixel_count());
  EXPECT_EQ(drawn_pixels(draw(field, camera_at({0, 0, -0.31}, {0, 0, -1}))), 0U);
  EXPECT_EQ(drawn_pixels(draw(field, camera_at({0, 0, -1.5}, {0, 0, -3}))), 0U);
  // Beside it: only a rim may be seen.
  EXPECT_EQ(drawn_pixels(draw(field, camera_at({0, 0, -1.5}, {3, 0, -1.5}))), 0U);
}

TEST(Drawing, OfAPixelAndOfManyMillions) {
  const DrawableField field(painted_field(kBox, PaintedBall{}));
  const Picture one = draw(field, camera_at({0, 0, -1.2}, {0, 0, 0}, 1, 1));
  EXPECT_EQ(drawn_pixels(one), 1U);
  EXPECT_NEAR(one.depth.at(0, 0), 0.9, kCell);
  const Picture large = draw(field, camera_at({0, 0, -1.2}, {0, 0, 0}, 8192, 8192));
  // A disc of half angle asin(0.3 / 1.2).
  const double radius = 4096 * std::tan(std::asin(0.25));
  EXPECT_NEAR(static_cast<double>(drawn_pixels(large)) / (std::numbers::pi * radius * radius), 1, 0.05);
  EXPECT_THROW(draw(field, camera_at({0, 0, -1.2}, {0, 0, 0}, 0, 8)), Error);
  EXPECT_THROW(draw(field, camera_at({0, 0, -1.2}, {0, 0, 0}, 20000, 8)), Error);
}

TEST(Drawing, NearerSurfaceHidesAlsoWhereHullsOverlap) {
  const DrawableField white(painted_field(kBox, [](const Eigen::Vector3d& p) {
    return testing::Paint{p.norm() - 0.3, {1, 1, 1}};
  }));
  const DrawableField black(painted_field(kBox, [](const Eigen::Vector3d& p) {
    return testing::Paint{(p - Eigen::Vector3d(0, 0, -0.03)).norm() - 0.3, {0, 0, 0}};
  }));
  // The black ball's surface lies two cells before the white one's.
  const std::vector<PosedField> layers{{&white}, {&black}};
  const Picture front = render(layers, camera_at({0, 0, -1.2}, {0, 0, 0}));
  EXPECT_LT(front.color.at(48, 36, 0), 40);
  EXPECT_EQ(front.front.at(48, 36), 2);
  const Picture back = render(layers, camera_at({0, 0, 1.2}, {0, 0, 0}));
  EXPECT_GT(back.color.at(48, 36, 0), 215);
  EXPECT_EQ(back.front.at(48, 36), 1);
}

TEST(Drawing, NothingOfFieldsThatAreEmptyAndAllOfOpaqueOnes) {
  const auto empty = painted_field(kBox, [](const Eigen::Vector3d&) { return testing::Paint{1}; });
  EXPECT_EQ(drawn_pixels(draw(DrawableField(empty), camera_at({0, 0, -1.2}, {0, 0, 0}))), 0U);
  EXPECT_EQ(drawn_pixels(draw(DrawableField(Field(empty.config)), camera_at({0, 0, -1.2}, {0, 0, 0}))), 0U);
  for (const float extreme : {1e4F, -1e4F}) {
    const auto full = painted_field(
        kBox, [](const Eigen::Vector3d&) { return testing::Paint{-1}; }, extreme);
    const Picture picture = draw(DrawableField(full), camera_at({0, 0, -1.2}, {0, 0, 0}));
    EXPECT_EQ(drawn_pixels(picture) > 0, extreme > 0);
  }
}

TEST(Drawing, NoRaySlipsThroughAFloor) {
  const DrawableField floor(testing::sloping_floor());
  for (int i = 0; i < 24; ++i) {
    const Picture picture = draw(floor, testing::camera_that_grazes(i));
    EXPECT_EQ(drawn_pixels(picture), picture.color.pixel_count()) << "camera " << i;
  }
}

TEST(Drawing, AThreadOneCellThickIsSeen) {
  const DrawableField field(painted_field(kBox, [](const Eigen::Vector3d& p) {
    return testing::Paint{std::hypot(p.y(), p.z()) - 0.7 * kCell, {1, 1, 1}};
  }));
  const Picture picture = draw(field, camera_at({0, 0, -0.8}, {0, 0, 0}, 96, 73));
  for (int u = 24; u < 72; ++u) {
    int most = 0;
    for (int v = 30; v < 42; ++v) most = std::max<int>(most, picture.color.at(u, v, 3));
    EXPECT_GT(most, 100) << "column " << u;
  }
}

TEST(Drawing, SameBitsForAnyNumberOfThreads) {
  const PaintedBall ball;
  const Camera camera = camera_at({0.4, 0.3, -1.0}, {0, 0, 0});
  std::vector<Picture> pictures;
  for (const int threads : {1, 2, 7}) {
    set_thread_count(threads);
    pictures.push_back(draw(DrawableField(painted_field(kBox, ball)), camera));
  }
  set_thread_count(0);
  for (std::size_t i = 1; i < pictures.size(); ++i) {
    EXPECT_TRUE(std::ranges::equal(pictures[i].color.values(), pictures[0].color.values()));
    EXPECT_TRUE(std::ranges::equal(pictures[i].depth.values(), pictures[0].depth.values()));
  }
}

TEST(Drawing, EveryInstructionSetDrawsTheSamePicture) {
  const PaintedBall ball{{0, 0, 0}, 0.12};
  const Camera camera = camera_at({0.2, 0.1, -0.4}, {0, 0, 0}, 48, 36);
  const Picture best = draw(DrawableField(painted_field(kBox, ball)), camera);
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    const Picture picture = draw(DrawableField(painted_field(kBox, ball)), camera);
    EXPECT_GT(psnr(picture, best), 45) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(Drawing, WithHalfTheDetailIsReadySoonerAndLooksNearlyTheSame) {
  const PaintedBall ball{{0.05, -0.02, 0.1}, 0.25};
  const DrawableField whole(painted_field(kBox, ball));
  const DrawableField half(painted_field(kBox, ball), nullptr, std::nullopt, BrickDetail::kHalf);
  EXPECT_EQ(half.derived().bricks.resolution(), whole.derived().bricks.resolution() / 2);
  EXPECT_LT(half.derived().bricks.count(), whole.derived().bricks.count() / 2);
  const Camera camera = camera_at({0.5, 0.2, -1.1}, ball.centre, 192, 144);
  const Picture picture = draw(half, camera);
  const BallError error = compare_ball(picture, camera, ball, SE3::Identity());
  EXPECT_LT(error.depth, 1.6 * kCell);
  EXPECT_GT(error.overlap, 0.9);
  EXPECT_GT(psnr(picture, draw(whole, camera)), 25);
}

TEST(Drawing, ShowsTheSameWhicheverPixelsAreDrawnFirst) {
  const DrawableField field(painted_field(kBox, PaintedBall{}));
  Camera camera = camera_at({0.3, 0.2, -0.7}, {0, 0, 0}, 192, 144);
  const Picture picture = draw(field, camera);
  camera.intrinsics.cx += 1; // everything one pixel to the right
  const Picture moved = draw(field, camera);
  double squared = 0;
  int largest = 0, count = 0;
  for (int v = 0; v < 144; ++v) {
    for (int u = 0; u + 1 < 192; ++u) {
      for (int c = 0; c < 4; ++c) {
        const int difference = picture.color.at(u, v, c) - moved.color.at(u + 1, v, c);
        squared += difference * difference;
        largest = std::max(largest, std::abs(difference));
        ++count;
      }
    }
  }
  EXPECT_GT(drawn_pixels(picture), 4000U);
  EXPECT_GT(10 * std::log10(255 * 255 / (squared / count)), 50) << "largest difference " << largest;
}

/// Nodes everywhere in the box; each turned about the vertical by `twist` times its height.
motion::Warp twisted(const std::shared_ptr<const motion::DeformationGraph>& graph, double twist, const SE3& pose) {
  std::vector<DualQuaternion> nodes;
  for (const Eigen::Vector3d& node : graph->nodes()) {
    SE3 rotation = SE3::Identity();
    rotation.rotate(Eigen::AngleAxisd(twist * node.y(), Eigen::Vector3d::UnitY()));
    nodes.push_back(DualQuaternion::from(pose * rotation));
  }
  return {graph, nodes};
}

TEST(Drawing, ADeformingLayerThatMovesAsOneIsDrawnAsARigidOne) {
  const auto graph = graph_of_box();
  const PaintedBall ball{{0.05, -0.02, 0.1}, 0.25};
  const DrawableField field(painted_field(kBox, ball), graph.get());
  SE3 canonical_to_world = SE3::Identity();
  canonical_to_world.rotate(Eigen::AngleAxisd(0.8, Eigen::Vector3d(3, 1, 2).normalized()));
  canonical_to_world.pretranslate(Eigen::Vector3d(0.3, 0.1, 2));
  const Camera camera = camera_at({0, 0, 0}, {0.3, 0.1, 2}, 192, 144);
  const PosedField posed_field = pose(field, twisted(graph, 0, canonical_to_world));
  const Picture picture = render({&posed_field, 1}, camera);
  const BallError error = compare_ball(picture, camera, ball, canonical_to_world);
  EXPECT_LT(error.depth, 0.8 * kCell);
  EXPECT_LT(error.color, 0.03);
  EXPECT_GT(error.overlap, 0.94);
  EXPECT_GT(psnr(picture, draw(field, camera, canonical_to_world)), 30);
}

/// Mean difference of a picture's colours from those of a ball that is twisted about the vertical, by `twist` radians
/// per metre: a ball that stays a ball while its colours turn.
double color_error_of_twisted(const PaintedBall& ball, double twist, const Camera& camera, const Picture& picture) {
  double error = 0;
  int count = 0;
  for (int v = 0; v < picture.depth.height(); ++v) {
    for (int u = 0; u < picture.depth.width(); ++u) {
      const Eigen::Vector3d direction = camera.camera_to_world.linear() * camera.intrinsics.unproject(u, v, 1);
      const double depth = ball.depth_of(camera.camera_to_world.translation(), direction);
      if (depth <= 0 || picture.depth.at(u, v) <= 0) continue;
      const Eigen::Vector3d point = camera.camera_to_world.translation() + depth * direction;
      const Eigen::Vector3d truth = ball(Eigen::AngleAxisd(-twist * point.y(), Eigen::Vector3d::UnitY()) * point).color;
      for (int c = 0; c < 3; ++c) {
        error += std::abs(picture.color.at(u, v, c) / 255.0 - 1 / (1 + std::exp(4 - 8 * truth[c]))) / 3;
      }
      ++count;
    }
  }
  return error / count;
}

TEST(Drawing, NothingIsDrawnOfNodesThatAreNotBorn) {
  const auto graph = graph_of_box();
  const PaintedBall ball;
  const DrawableField field(painted_field(kBox, ball), graph.get());
  const motion::Warp warp = twisted(graph, 0, SE3::Identity());
  motion::UnbornNodes unborn;
  for (const Eigen::Vector3d& node : graph->nodes()) unborn.push_back(node.x() > 0);
  const PosedField half = pose(field, warp, unborn);
  const PosedField whole = pose(field, warp);
  constexpr double kEdge = 0.1; // metres: births are kept to bricks
  for (const Eigen::Vector3d& from : {Eigen::Vector3d(0, 0, -1.2), Eigen::Vector3d(1.2, 0.1, 0),
                                      Eigen::Vector3d(-1.2, 0.1, 0), Eigen::Vector3d(0.15, 0, 0)}) {
    const Camera camera = camera_at(from, {0, 0, from.x() == 0.15 ? 1.0 : 0.0}, 192, 144);
    const Picture picture = render({&half, 1}, camera);
    const Picture all = render({&whole, 1}, camera);
    std::size_t there = 0;
    for (int v = 0; v < picture.depth.height(); ++v) {
      for (int u = 0; u < picture.depth.width(); ++u) {
        const auto place = [&](const Picture& of) -> Eigen::Vector3d {
          return camera.camera_to_world * camera.intrinsics.unproject(u, v, of.depth.at(u, v));
        };
        if (picture.depth.at(u, v) > 0) {
          ++there;
          EXPECT_LT(place(picture).x(), kEdge) << u << ' ' << v;
        }
        if (all.depth.at(u, v) > 0 && place(all).x() < -kEdge) {
          EXPECT_NEAR(picture.depth.at(u, v), all.depth.at(u, v), kCell) << u << ' ' << v;
        }
      }
    }
    if (from.x() != 0.15) {
      EXPECT_GT(there, 500U);
    }
  }
  motion::UnbornNodes none(graph->nodes().size(), true);
  const PosedField gone = pose(field, warp, none);
  EXPECT_EQ(drawn_pixels(render({&gone, 1}, camera_at({0, 0, -1.2}, {0, 0, 0}))), 0U);
}

TEST(Drawing, ATwistedLayerShowsTheCanonicalPointsThatTheWarpCarriesThere) {
  constexpr double kTwist = 3;
  const auto graph = graph_of_box();
  const PaintedBall ball;
  const DrawableField field(painted_field(kBox, ball), graph.get());
  const motion::Warp warp = twisted(graph, kTwist, SE3::Identity());
  const Camera camera = camera_at({0.5, 0.2, -1.1}, {0, 0, 0}, 192, 144);
  const PosedField posed_field = pose(field, warp);
  const Picture picture = render({&posed_field, 1}, camera);
  const Picture untwisted = draw(field, camera);
  EXPECT_NEAR(static_cast<double>(drawn_pixels(picture)) / static_cast<double>(drawn_pixels(untwisted)), 1, 0.03);
  const double error = color_error_of_twisted(ball, kTwist, camera, picture);
  EXPECT_LT(error, 0.025);
  EXPECT_GT(color_error_of_twisted(ball, kTwist, camera, untwisted), 4 * error) << "the twist must show";
  EXPECT_THROW(pose(DrawableField(painted_field(kBox, ball)), warp), Error);
}

} // namespace
} // namespace kinora::fields
