#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "fields/occupancy.h"

namespace kinora::fields {
namespace {

Occupancy random_cells(std::uint64_t seed, int count) {
  Occupancy occupancy(64);
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    occupancy.set(static_cast<int>(random.below(64)), static_cast<int>(random.below(64)),
                  static_cast<int>(random.below(64)));
  }
  return occupancy;
}

TEST(DistanceField, EqualsBruteForce) {
  const Occupancy occupancy = random_cells(1, 40);
  const DistanceField distances(occupancy);
  Random random(2);
  for (int k = 0; k < 300; ++k) {
    const int x = static_cast<int>(random.below(64));
    const int y = static_cast<int>(random.below(64));
    const int z = static_cast<int>(random.below(64));
    int nearest = DistanceField::kFarthest;
    for (int c = 0; c < 64 * 64 * 64; ++c) {
      if (!occupancy.at(c % 64, c / 64 % 64, c / 4096)) continue;
      nearest = std::min(nearest, std::max({std::abs(c % 64 - x), std::abs(c / 64 % 64 - y), std::abs(c / 4096 - z)}));
    }
    EXPECT_EQ(distances.at(x, y, z), nearest);
  }
}

TEST(OccupiedIntervals, CoverExactlyTheOccupiedPointsOfARay) {
  const Occupancy occupancy = random_cells(3, 20000);
  const DistanceField distances(occupancy);
  Random random(4);
  int occupied_points = 0;
  for (int k = 0; k < 200; ++k) {
    FieldRay ray{};
    for (std::size_t a = 0; a < 3; ++a) {
      ray.origin[a] = -0.5F + 2 * random.uniform();
      // Some rays run along an axis.
      ray.direction[a] = random.below(4) == 0 ? 0.0F : random.uniform() - 0.5F;
    }
    std::vector<Interval> intervals;
    OccupiedIntervals walk(distances, ray, 0.1F, 5.0F);
    for (Interval i{}; walk.next(i);) intervals.push_back(i);
    for (int s = 0; s < 2000; ++s) {
      const float depth = 0.1F + 4.9F * (static_cast<float>(s) + 0.5F) / 2000;
      std::array<float, 3> cell{};
      bool inside = true;
      float margin = 1; // distance to a cell's wall: too near, and rounding decides
      for (std::size_t a = 0; a < 3; ++a) {
        cell[a] = (ray.origin[a] + depth * ray.direction[a]) * 64;
        inside = inside && cell[a] > 0 && cell[a] < 64;
        margin = std::min(margin, std::abs(cell[a] - std::round(cell[a])));
      }
      if (margin < 2e-3F) continue;
      const bool expected =
          inside && occupancy.at(static_cast<int>(cell[0]), static_cast<int>(cell[1]), static_cast<int>(cell[2]));
      const bool found = std::any_of(intervals.begin(), intervals.end(),
                                     [depth](const Interval& i) { return depth >= i.begin && depth <= i.end; });
      ASSERT_EQ(found, expected) << "ray " << k << " depth " << depth;
      occupied_points += expected ? 1 : 0;
    }
  }
  EXPECT_GT(occupied_points, 1000);
}

// The camera often sees along the walls between cells (its axis through the middle of the box), where rounding lays
// points on either side. A walk that trusts those points makes no headway: these rays would take it minutes.
TEST(OccupiedIntervals, MakeHeadwayInsideTheWallsBetweenCells) {
  const Occupancy occupancy = random_cells(6, 20000);
  const DistanceField distances(occupancy);
  Random random(7);
  for (int k = 0; k < 20000; ++k) {
    FieldRay ray{{0, 0, -0.25F}, {0, 0, 0.5F + random.uniform()}, 1};
    for (std::size_t a = 0; a < 2; ++a) {
      ray.origin[a] = static_cast<float>(1 + random.below(62)) / 64;
      ray.direction[a] = (random.uniform() - 0.5F) * std::pow(10.0F, -static_cast<float>(random.below(12)));
    }
    float last = 0;
    int pieces = 0;
    OccupiedIntervals walk(distances, ray, 0.0F, 10.0F);
    for (Interval i{}; walk.next(i); ++pieces) {
      ASSERT_LE(i.begin, i.end);
      ASSERT_GE(i.begin, last);
      last = i.end;
    }
    ASSERT_LE(pieces, 3 * 64);
  }
}

TEST(OccupiedIntervals, EndForRaysThatMissOrStandStill) {
  const DistanceField distances(random_cells(5, 4000));
  Interval interval{};
  EXPECT_FALSE(OccupiedIntervals(distances, {{2, 2, 2}, {1, 0, 0}, 1}, 0, 100).next(interval));
  EXPECT_FALSE(OccupiedIntervals(distances, {{-1, 0.5F, 0.5F}, {-1, 0, 0}, 1}, 0, 100).next(interval));
  OccupiedIntervals standing(distances, {{0.5F, 0.5F, 0.5F}, {0, 0, 0}, 1}, 0, 100);
  int pieces = 0;
  while (standing.next(interval) && pieces < 10) ++pieces;
  EXPECT_LT(pieces, 10);
}

} // namespace
} // namespace kinora::fields
