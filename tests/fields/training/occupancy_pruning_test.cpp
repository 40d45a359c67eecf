#include "fields/training/occupancy_pruning.h"

#include <gtest/gtest.h>

#include "fields/scenes/painted_field.h"
#include "fields/scenes/same_cells.h"

namespace kinora::fields {
namespace {

using testing::painted_field;
using testing::PaintedBall;

const FieldBox kBox{Eigen::Vector3d(-0.5, -0.5, -0.5), 1.0};

/// Everything is occupied.
Field full_field(const PaintedBall& ball) {
  Field field = painted_field(kBox, ball);
  std::fill(field.occupancy.words().begin(), field.occupancy.words().end(), ~std::uint64_t{0});
  return field;
}

TEST(OccupancyPruning, GoAndOthersStay) {
  const PaintedBall ball;
  Field field = full_field(ball);
  prune_occupancy(field);
  const int n = field.occupancy.resolution();
  const double cell = kBox.side / n;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const Eigen::Vector3d middle = kBox.origin + cell * (Eigen::Vector3d(x, y, z).array() + 0.5).matrix();
        const double distance = ball(middle).distance;
        // The density falls to nothing within a cell of the surface, a cell reaches 0.9 of its side from its middle.
        if (distance > -cell && distance < 2 * cell) continue;
        EXPECT_EQ(field.occupancy.at(x, y, z), distance < 0) << x << " " << y << " " << z;
      }
    }
  }
}

TEST(OccupancyPruning, WhatWasEmptyStaysEmpty) {
  Field field = painted_field(kBox, PaintedBall{});
  std::fill(field.occupancy.words().begin(), field.occupancy.words().end(), 0);
  prune_occupancy(field);
  for (const std::uint64_t word : field.occupancy.words()) EXPECT_EQ(word, 0U);
}

TEST(OccupancyPruning, AreTheSameForAnyNumberOfThreads) {
  testing::expect_same_cells_for_any_number_of_threads(full_field(PaintedBall{}),
                                                       [](Field& field) { prune_occupancy(field); });
}

} // namespace
} // namespace kinora::fields
