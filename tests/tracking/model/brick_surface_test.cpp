#include "tracking/model/brick_surface.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tracking/scenes/scanned_sphere.h"

namespace kinora::tracking {
namespace {

using testing::scanned_sphere;

bool same_points(std::span<const SurfacePoint> a, std::span<const SurfacePoint> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const SurfacePoint& p, const SurfacePoint& q) {
    return p.position == q.position && p.normal == q.normal && p.weight == q.weight && p.brick == q.brick;
  });
}

float weight_of_one_view() {
  std::vector<float> weights;
  for (const SurfacePoint& point : scanned_sphere().surface_points()) weights.push_back(point.weight);
  std::nth_element(weights.begin(), weights.begin() + static_cast<std::ptrdiff_t>(weights.size() / 2), weights.end());
  return weights[weights.size() / 2];
}

TEST(BrickSurface, TakesAnewTheBricksThatAreMarked) {
  const TsdfVolume once = scanned_sphere();
  const TsdfVolume often = scanned_sphere(5);
  ASSERT_EQ(once.brick_count(), often.brick_count());
  BrickSurface surface;
  surface.update_points(once, {}, 0);
  EXPECT_TRUE(same_points(surface.points(), once.surface_points()));
  std::vector<std::uint8_t> changed(once.brick_count(), 0);
  for (std::size_t b = 0; b < changed.size(); b += 2) changed[b] = 1;
  surface.update_points(often, changed, 0);
  for (std::size_t b = 0; b < changed.size(); ++b) {
    std::vector<SurfacePoint> expected;
    (b % 2 == 0 ? often : once).append_surface(b, 0, expected);
    EXPECT_TRUE(same_points(surface.points_of([&](std::size_t brick) { return brick == b; }), expected));
  }
}

TEST(BrickSurface, SkinIsThatOfTheGraphAlsoAfterItHasGrown) {
  const TsdfVolume volume = scanned_sphere();
  BrickSurface surface;
  surface.update_points(volume, {}, 0);
  std::vector<Eigen::Vector3d> nodes = {{0, 0, -0.15}};
  BrickInfluences influences;
  for (const Eigen::Vector3d& node : {Eigen::Vector3d(0.05, 0, -0.14), Eigen::Vector3d(-0.1, 0.05, -0.1)}) {
    nodes.push_back(node);
    const auto graph = std::make_shared<const motion::DeformationGraph>(nodes, 0.03, 0.07);
    influences.update(volume, graph);
    surface.update_skinning(influences);
    ASSERT_EQ(surface.skin().size(), surface.points().size());
    for (std::size_t i = 0; i < surface.skin().size(); ++i) {
      const motion::Influence expected = graph->influence(surface.points()[i].position.cast<double>());
      ASSERT_EQ(surface.skin()[i].count > 0, expected.count > 0);
      for (std::size_t k = 0; k < motion::Influence::kMax; ++k) {
        EXPECT_NEAR(surface.skin()[i].weights[k], expected.weights[k], 1e-4);
      }
    }
  }
}

TEST(BrickSurface, TellsWhichChangedBricksLieBeyondAllNodes) {
  const TsdfVolume volume = scanned_sphere();
  BrickSurface surface;
  surface.update_points(volume, {}, 0);
  const std::vector<Eigen::Vector3d> nodes = {{0, 0, -0.15}, {0.05, 0, -0.14}};
  constexpr double kReach = 0.07;
  const auto has_points = [&](std::size_t brick) {
    return !surface.points_of([&](std::size_t b) { return b == brick; }).empty();
  };
  const auto lies_beyond = [&](std::size_t brick) {
    const std::vector<SurfacePoint> points = surface.points_of([&](std::size_t b) { return b == brick; });
    return std::any_of(points.begin(), points.end(), [&](const SurfacePoint& point) {
      return std::none_of(nodes.begin(), nodes.end(), [&](const Eigen::Vector3d& node) {
        return (node - point.position.cast<double>()).norm() <= kReach;
      });
    });
  };
  std::vector<std::uint8_t> changed(volume.brick_count() - 3, 0);
  for (std::size_t b = 0; b < changed.size(); b += 2) changed[b] = 1;
  const auto is_changed = [&](std::size_t b) { return b >= changed.size() || changed[b] != 0; };
  const std::vector<std::uint8_t> bare = surface.unsupported_bricks(nodes, kReach, 0, changed);
  BrickInfluences influences;
  influences.update(volume, std::make_shared<const motion::DeformationGraph>(nodes, 0.05, 0.1));
  surface.update_skinning(influences);
  const std::vector<std::uint8_t> marks = surface.unsupported_bricks(nodes, kReach, 0, changed);
  ASSERT_EQ(marks.size(), volume.brick_count());
  for (std::size_t b = 0; b < marks.size(); ++b) {
    EXPECT_EQ(bare[b] != 0, is_changed(b) && has_points(b)) << b;
    EXPECT_EQ(marks[b] != 0, is_changed(b) && lies_beyond(b)) << b;
  }
  EXPECT_LT(std::count(marks.begin(), marks.end(), 1), std::count(bare.begin(), bare.end(), 1));
  const std::vector<std::uint8_t> heavy = surface.unsupported_bricks(nodes, kReach, 1e6F, changed);
  EXPECT_EQ(std::count(heavy.begin(), heavy.end(), 1), 0);
}

TEST(BrickSurface, WhatWasSeenOftenRestsButForItsTurn) {
  constexpr std::size_t kInterval = 4;
  BrickSurface surface;
  surface.update_points(scanned_sphere(), {}, weight_of_one_view());
  const std::vector<std::uint8_t> young = surface.skipped(0, kInterval);
  EXPECT_EQ(std::count(young.begin(), young.end(), 1), 0);
  surface.update_points(scanned_sphere(20), {}, weight_of_one_view());
  std::vector<int> rests(young.size(), 0);
  for (std::size_t frame = 7; frame < 7 + kInterval; ++frame) {
    const std::vector<std::uint8_t> marks = surface.skipped(frame, kInterval);
    for (std::size_t b = 0; b < marks.size(); ++b) rests[b] += marks[b];
  }
  EXPECT_GT(std::count(rests.begin(), rests.end(), 3), 10);
  EXPECT_EQ(std::count(rests.begin(), rests.end(), 4), 0);
}

} // namespace
} // namespace kinora::tracking
