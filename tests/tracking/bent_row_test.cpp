#include "tracking/bent_row.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace kinora::tracking {
namespace {

constexpr int kWidth = 37;
constexpr int kHeight = 22;
constexpr int kStride = 4;
constexpr int kColumns = 10;

/// A wall one metre away with bumps, holes and cells that show nothing.
struct View {
  std::vector<float> planes, weights, intensity, places;

  explicit View(Random& random) {
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const float tilt = 0.1F * random.uniform();
      planes.insert(planes.end(), {tilt, 0, -std::sqrt(1 - tilt * tilt), 1 + 0.02F * random.uniform()});
      weights.push_back(i % 5 == 0 ? 0 : random.uniform());
      intensity.push_back(random.uniform());
    }
    for (int i = 0; i < kColumns * 6; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        places.push_back(i % 7 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.04F * random.uniform());
      }
    }
  }
  BentImages images() const {
    return {planes.data(),
            weights.data(),
            intensity.data(),
            places.data(),
            kWidth,
            kHeight,
            kStride,
            kColumns,
            60,
            60,
            18,
            11,
            0.05F,
            0.03F,
            0.04F,
            5};
  }
};

using Values = std::array<float, BentRow::kVoxels>;

void fuse_plainly(const BentImages& view, const BentRow& row, Values& distance, Values& weight, Values& intensity) {
  for (std::size_t i = 0; i < BentRow::kVoxels; ++i) {
    const std::size_t half = i / 4;
    if (!row.known[half]) continue;
    std::array<double, 3> p{};
    for (std::size_t a = 0; a < 3; ++a) {
      p[a] = row.along[half][a] + (static_cast<double>(i) - 4.0 * static_cast<double>(half)) / 4 *
                                      (row.along[half + 1][a] - row.along[half][a]);
    }
    if (!(p[2] > view.nearest)) continue;
    const double u = std::floor(view.fx * p[0] / p[2] + view.cx + 0.5);
    const double v = std::floor(view.fy * p[1] / p[2] + view.cy + 0.5);
    if (!(u >= 0 && v >= 0 && u < view.width && v < view.height)) continue;
    const auto pixel = static_cast<std::size_t>(v * view.width + u);
    const float* plane = view.planes + 4 * pixel;
    const double off = plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] + plane[3];
    if (!(view.weights[pixel] > 0) || std::abs(off) >= view.truncation) continue;
    const float* place = view.places + 3 * static_cast<std::size_t>(std::floor(v / view.stride) * view.columns +
                                                                    std::floor(u / view.stride));
    const double dx = place[0] - (row.first[0] + static_cast<float>(i) * row.voxel);
    const double dy = place[1] - row.first[1];
    const double dz = place[2] - row.first[2];
    if (!(dx * dx + dy * dy + dz * dz < view.reach * view.reach)) continue;
    const double trust = off < 0 ? 1 + off / view.truncation : 1;
    const double added = view.weights[pixel] * trust * trust;
    const double share = added / (weight[i] + added);
    distance[i] += static_cast<float>(share * (off - distance[i]));
    intensity[i] += static_cast<float>(share * (view.intensity[pixel] - intensity[i]));
    weight[i] = static_cast<float>(std::min<double>(weight[i] + added, view.max_weight));
  }
}

TEST(BentRow, IsFusedAsByAPlainLoop) {
  Random random(5);
  const View view(random);
  int taught = 0;
  for (int round = 0; round < 2000; ++round) {
    BentRow row{};
    const float z = 0.97F + 0.08F * random.uniform();
    const float x = 0.8F * (random.uniform() - 0.5F);
    const float y = 0.5F * (random.uniform() - 0.5F);
    for (std::size_t i = 0; i < 3; ++i) row.along[i] = {x + 0.02F * static_cast<float>(i), y, z};
    row.along[1][2] += 0.005F * random.uniform();
    row.known = {round % 9 != 0, round % 11 != 0};
    row.first = {0.02F * random.uniform(), 0.04F * random.uniform(), 0.04F * random.uniform()};
    row.voxel = 0.005F;
    Values distance{}, weight{}, intensity{};
    for (std::size_t i = 0; i < weight.size(); ++i) {
      weight[i] = round % 3 == 0 ? 0 : 5 * random.uniform();
      distance[i] = 0.03F * random.uniform();
    }
    Values distances = distance, weights = weight, intensities = intensity;
    fuse_row(view.images(), row, distance.data(), weight.data(), intensity.data());
    fuse_plainly(view.images(), row, distances, weights, intensities);
    for (std::size_t i = 0; i < weight.size(); ++i) {
      EXPECT_NEAR(distance[i], distances[i], 1e-6) << round << ' ' << i;
      EXPECT_NEAR(weight[i], weights[i], 1e-4) << round << ' ' << i;
      EXPECT_NEAR(intensity[i], intensities[i], 1e-4) << round << ' ' << i;
      if (intensities[i] != 0) ++taught;
    }
  }
  EXPECT_GT(taught, 500);
}

TEST(BentRow, LearnsNothingWhereverItMayBe) {
  Random random(6);
  const View view(random);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  constexpr float kFar = std::numeric_limits<float>::max();
  for (const std::array<float, 3>& place :
       {std::array{0.0F, 0.0F, -1.0F}, std::array{0.0F, 0.0F, 0.0F}, std::array{kFar, kFar, 1.0F},
        std::array{-kFar, 0.0F, kFar}, std::array{kNone, kNone, kNone}, std::array{0.0F, 0.0F, 2.0F}}) {
    BentRow row{};
    row.along = {place, place, place};
    row.known = {true, true};
    row.voxel = 0.005F;
    Values distance{}, weight{}, intensity{};
    fuse_row(view.images(), row, distance.data(), weight.data(), intensity.data());
    EXPECT_EQ(weight, Values{});
    EXPECT_EQ(distance, Values{});
  }
}

} // namespace
} // namespace kinora::tracking
