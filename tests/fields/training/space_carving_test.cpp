// Cells that the capture's cameras see past are emptied, whatever is really there stays.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "fields/scenes/analytic_scene.h"
#include "fields/scenes/painted_field.h"
#include "fields/training/space_carving.h"

namespace kinora::fields {
namespace {

constexpr int kBall = 2;
const Scene kScene;
const FieldBox kBox{{-0.5, -0.5, 1.5}, 1};

/// The scene's ball, and beside it another one of radius 5 cm, which hangs together with it or not.
Field with_isolated_part(const Eigen::Vector3d& isolated_part) {
  return testing::painted_field(kBox, [&](const Eigen::Vector3d& p) {
    const double ball = std::abs((p - kScene.centre).norm() - kScene.radius); // hollow: nobody looks inside
    return testing::Paint{std::min(ball, (p - isolated_part).norm() - 0.05)};
  });
}

bool holds(const Field& field, const Eigen::Vector3d& point) {
  const Eigen::Vector3i cell = ((point - kBox.origin) * field.config.occupancy_resolution).cast<int>();
  return field.occupancy.at(cell.x(), cell.y(), cell.z());
}

std::size_t drop(Field& field, const PixelStore& store) {
  return carve_free_space({store, kBall, motion::Motion::still()}, field);
}

TEST(SpaceCarving, NoSurfaceIsDroppedWhereAllViewsAgree) {
  Field field = with_isolated_part(kScene.centre);
  const Occupancy before = field.occupancy;
  drop(field, store_of(kScene));
  const int r = before.resolution();
  const double side = kBox.side / r;
  int kept = 0;
  for (int z = 0; z < r; ++z) {
    for (int y = 0; y < r; ++y) {
      for (int x = 0; x < r; ++x) {
        const Eigen::Vector3d centre = kBox.origin + side * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
        if (std::abs((centre - kScene.centre).norm() - kScene.radius) > side / 2) continue;
        EXPECT_EQ(field.occupancy.at(x, y, z), before.at(x, y, z));
        ++kept;
      }
    }
  }
  EXPECT_GT(kept, 1000);
}

TEST(SpaceCarving, ACrumbThatIsSeenPastIsDropped) {
  const Eigen::Vector3d isolated_part = kScene.centre + Eigen::Vector3d(0, -0.43, 0);
  Field field = with_isolated_part(isolated_part);
  ASSERT_TRUE(holds(field, isolated_part));
  EXPECT_GT(drop(field, store_of(kScene)), 20U);
  EXPECT_FALSE(holds(field, isolated_part));
  EXPECT_TRUE(holds(field, kScene.centre - Eigen::Vector3d(0, 0, kScene.radius)));
}

TEST(SpaceCarving, ACrumbIsDroppedWhereASixthOfThePixelsIsStored) {
  PixelStore store(kWidth * kHeight * 2, 12);
  for (int i = 0; i < 12; ++i) store.add(kScene.frame(i, 0.05 * (i - 6)), i);
  const Eigen::Vector3d isolated_part = kScene.centre + Eigen::Vector3d(0, -0.43, 0);
  Field field = with_isolated_part(isolated_part);
  drop(field, store);
  EXPECT_FALSE(holds(field, isolated_part));
  EXPECT_TRUE(holds(field, kScene.centre - Eigen::Vector3d(0, 0, kScene.radius)));
}

TEST(SpaceCarving, AWebThatHangsTogetherWithTheLayerIsDropped) {
  const Eigen::Vector3d web = kScene.centre + Eigen::Vector3d(0, -0.34, 0);
  Field field = with_isolated_part(web);
  const Eigen::Vector3d tip = web - Eigen::Vector3d(0, 0.04, 0);
  ASSERT_TRUE(holds(field, tip));
  drop(field, store_of(kScene));
  EXPECT_FALSE(holds(field, tip));
}

TEST(SpaceCarving, APieceThatIsReallyApartStays) {
  // Cameras that measure the small ball alone, while the field's largest part is where none of them looks.
  Scene small;
  small.centre = kScene.centre - Eigen::Vector3d(0, 0, 0.4);
  small.radius = 0.05;
  Field field = testing::painted_field(kBox, [&](const Eigen::Vector3d& p) {
    const double hidden = (p - Eigen::Vector3d(0, 0, 2.35)).norm() - 0.08; // behind it
    return testing::Paint{std::min(std::abs((p - small.centre).norm() - small.radius), hidden)};
  });
  PixelStore store(1'000'000, 1);
  store.add(small.frame(0, 0), 0);
  const Eigen::Vector3d front = small.centre - Eigen::Vector3d(0, 0, small.radius);
  drop(field, store);
  EXPECT_TRUE(holds(field, front));
}

TEST(SpaceCarving, WhatNobodyLooksAtStays) {
  Field field = with_isolated_part(kScene.centre);
  const std::size_t before = field.occupancy.count();
  EXPECT_EQ(drop(field, PixelStore(1000, 1)), 0U);
  EXPECT_EQ(field.occupancy.count(), before);
}

TEST(SpaceCarving, AreTheSameForOneThreadAndMany) {
  std::vector<std::vector<std::uint64_t>> words;
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    Field field = with_isolated_part(kScene.centre + Eigen::Vector3d(0, -0.34, 0));
    drop(field, store_of(kScene));
    words.push_back(field.occupancy.words());
  }
  set_thread_count(0);
  EXPECT_EQ(words[0], words[1]);
}

} // namespace
} // namespace kinora::fields
