#include "fields/model/enclosed_cells.h"

#include <gtest/gtest.h>

#include <deque>

#include "core/random.h"

namespace kinora::fields {
namespace {

using Cell = std::array<int, 3>;

/// As defined: cell after cell.
Occupancy enclosed_by_steps(const Occupancy& occupancy) {
  const int n = occupancy.resolution();
  Occupancy outside(n);
  std::deque<Cell> front;
  const auto reach = [&](int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x >= n || y >= n || z >= n) return;
    if (occupancy.at(x, y, z) || outside.at(x, y, z)) return;
    outside.set(x, y, z);
    front.push_back({x, y, z});
  };
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      for (const int face : {0, n - 1}) {
        reach(face, a, b);
        reach(a, face, b);
        reach(a, b, face);
      }
    }
  }
  while (!front.empty()) {
    const auto [x, y, z] = front.front();
    front.pop_front();
    for (const int step : {-1, 1}) {
      reach(x + step, y, z);
      reach(x, y + step, z);
      reach(x, y, z + step);
    }
  }
  Occupancy enclosed(n);
  for (std::size_t w = 0; w < enclosed.words().size(); ++w) {
    enclosed.words()[w] = ~(occupancy.words()[w] | outside.words()[w]);
  }
  return enclosed;
}

TEST(EnclosedCells, AreThoseThatNoWayFromOutsideLeadsTo) {
  Random random(7, 0);
  for (const int resolution : {64, 128}) {
    for (const float share : {0.1F, 0.3F, 0.35F, 0.6F, 0.9F}) {
      Occupancy occupancy(resolution);
      for (int z = 0; z < resolution; ++z) {
        for (int y = 0; y < resolution; ++y) {
          for (int x = 0; x < resolution; ++x) occupancy.set(x, y, z, random.uniform() < share);
        }
      }
      EXPECT_EQ(enclosed_cells(occupancy).words(), enclosed_by_steps(occupancy).words()) << resolution << " " << share;
    }
  }
}

TEST(EnclosedCells, AShellHoldsItsInsideUntilItHasAHole) {
  Occupancy shell(64);
  const auto is_shell = [](int x, int y, int z) {
    const int far = std::max({std::abs(x - 32), std::abs(y - 32), std::abs(z - 32)});
    return far == 20;
  };
  for (int z = 0; z < 64; ++z) {
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) shell.set(x, y, z, is_shell(x, y, z));
    }
  }
  EXPECT_EQ(enclosed_cells(shell).count(), 39U * 39U * 39U);
  shell.set(12, 30, 30, false);
  EXPECT_EQ(enclosed_cells(shell).count(), 0U);
  EXPECT_EQ(enclosed_cells(Occupancy(64)).count(), 0U);
}

} // namespace
} // namespace kinora::fields
