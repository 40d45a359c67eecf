#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "fields/sampling/morton_order.h"

namespace kinora::fields {
namespace {

struct Point {
  std::array<float, 3> position;
  std::size_t number;
};

TEST(RayOrder, SortsByCellAndKeepsTheOrderWithin) {
  Random random(3);
  std::vector<Point> points(50'000);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = {{2 * random.uniform() - 0.5F, random.uniform(), random.uniform()}, i}; // some outside
  std::vector<Point> expected = points;
  const auto position_of = [](const Point& p) { return p.position; };
  std::stable_sort(expected.begin(), expected.end(),
                   [](const Point& a, const Point& b) { return morton_code(a.position) < morton_code(b.position); });
  sort_by_morton_code(points, position_of);
  for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(points[i].number, expected[i].number);
}

TEST(RayOrder, CodesInterleaveTheBitsOfTheCells) {
  EXPECT_EQ(morton_code({0, 0, 0}), 0U);
  EXPECT_EQ(morton_code({1.5F / 64, 0, 0}), 1U);
  EXPECT_EQ(morton_code({0, 1.5F / 64, 0}), 2U);
  EXPECT_EQ(morton_code({0, 2.5F / 64, 1.5F / 64}), 4U + 16U);
  EXPECT_EQ(morton_code({7, 7, 7}), kOrderCells * kOrderCells * kOrderCells - 1);
  EXPECT_EQ(morton_code({NAN, -INFINITY, 0}), 0U);
}

} // namespace
} // namespace kinora::fields
