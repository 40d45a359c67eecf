#include <algorithm>
#include <bit>

#include <gtest/gtest.h>

#include "core/random.h"
#include "fields/sampling/occupancy.h"
#include "fields/sampling/occupied_points.h"
#include "support/every_instruction_set.h"

namespace kinora::fields {
namespace {

TEST(Occupancy, IsMarkedAlongAPieceOfARayAndNowhereElse) {
  Random random(3);
  for (int k = 0; k < 100; ++k) {
    FieldRay ray{};
    for (std::size_t a = 0; a < 3; ++a) {
      ray.origin[a] = -0.5F + 2 * random.uniform();
      // Some rays run along an axis.
      ray.direction[a] = random.below(4) == 0 ? 0.0F : random.uniform() - 0.5F;
    }
    const Interval segment{0.5F, 1.5F};
    Occupancy occupancy(64);
    mark_occupied(occupancy, ray, segment);
    Occupancy touched(64);
    for (int s = 0; s <= 4000; ++s) {
      const std::array<float, 3> at = point_at(ray, 0.5F + static_cast<float>(s) / 4000);
      if (std::any_of(at.begin(), at.end(), [](float x) { return !(x >= 0 && x < 1); })) continue;
      touched.set(static_cast<int>(64 * at[0]), static_cast<int>(64 * at[1]), static_cast<int>(64 * at[2]));
    }
    std::size_t beside = 0;
    for (std::size_t w = 0; w < touched.words().size(); ++w) {
      beside += static_cast<std::size_t>(std::popcount(occupancy.words()[w] & ~touched.words()[w]));
    }
    EXPECT_LE(beside, 2U); // where rounding lays a point on the other side of a wall
    // What is missed, within the box, has a neighbour that is not.
    for (int cell = 0; cell < 62 * 62 * 62; ++cell) {
      const std::array<int, 3> c{1 + cell % 62, 1 + cell / 62 % 62, 1 + cell / (62 * 62)};
      if (!touched.at(c[0], c[1], c[2])) continue;
      bool found = false;
      for (int n = 0; n < 27; ++n) found |= occupancy.at(c[0] + n % 3 - 1, c[1] + n / 3 % 3 - 1, c[2] + n / 9 - 1);
      EXPECT_TRUE(found);
    }
  }
}

TEST(Occupancy, IsCoarselyOccupiedWhereAnyOfItsCellsIs) {
  Occupancy occupancy(64);
  occupancy.set(5, 62, 17);
  const Occupancy coarse = coarsened(occupancy, 4);
  EXPECT_EQ(coarse.count(), 1U);
  EXPECT_TRUE(coarse.at(1, 15, 4));
}

class OccupiedPointsOn : public OnEveryInstructionSet {};

TEST_P(OccupiedPointsOn, AreThoseOfAPlainLoop) {
  constexpr int kSide = 64;
  Random random(9);
  Occupancy occupancy(kSide);
  for (int k = 0; k < 20'000; ++k) { // in some coarse cells, not in others
    const auto cell = [&random] { return static_cast<int>(random.below(kSide / 8) * 8 + random.below(5)); };
    occupancy.set(cell(), cell(), cell());
  }
  const OccupiedPoints occupied(occupancy);
  std::size_t found = 0;
  std::size_t asked = 0;
  for (std::size_t rays = 0; rays <= RayPoints::kMaxRays; ++rays) {
    RayPoints points;
    std::vector<FieldRay> chosen;
    for (std::size_t r = 0; r < rays; ++r) {
      FieldRay ray{};
      for (std::size_t a = 0; a < 3; ++a) {
        ray.origin[a] = -0.5F + 2 * random.uniform(); // some points are outside the box
        ray.direction[a] = random.uniform() - 0.5F;
      }
      chosen.push_back(ray);
      points.append(ray);
      points.points[r] = static_cast<std::int32_t>(random.below(RayPoints::kMaxPoints + 1));
      for (auto& depth : points.depth) depth[r] = random.uniform();
    }
    points.occupied.fill(0xABCD);
    occupied.find(points);
    for (std::size_t r = 0; r < rays; ++r) {
      std::uint32_t expected = 0;
      for (int k = 0; k < points.points[r]; ++k) {
        const std::array<float, 3> at = point_at(chosen[r], points.depth[static_cast<std::size_t>(k)][r]);
        const auto cell = [&at](std::size_t a) { return std::clamp(static_cast<int>(kSide * at[a]), 0, kSide - 1); };
        if (occupancy.at(cell(0), cell(1), cell(2))) expected |= 1U << k;
      }
      EXPECT_EQ(points.occupied[r], expected);
      found += static_cast<std::size_t>(std::popcount(expected));
      asked += static_cast<std::size_t>(points.points[r]);
    }
  }
  EXPECT_GT(found, asked / 50);
  EXPECT_LT(found, asked / 2);
}

INSTANTIATE_TEST_SUITE_P(Sets, OccupiedPointsOn, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::fields
