#include <algorithm>
#include <bit>

#include <gtest/gtest.h>

#include "core/random.h"
#include "fields/occupancy.h"

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
    const Interval piece{0.5F, 1.5F};
    Occupancy occupancy(64);
    mark_occupied(occupancy, ray, piece);
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

} // namespace
} // namespace kinora::fields
