#include "tracking/tsdf/warped_brick.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "support/every_instruction_set.h"

namespace kinora::tracking {
namespace {

constexpr int kWidth = 37;
constexpr int kHeight = 22;
constexpr int kStride = 4;
constexpr int kColumns = 10;

/// A wall one metre away with bumps, holes and cells that show nothing.
struct View {
  std::vector<float> planes, weights, intensity, positions;

  explicit View(Random& random) {
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const float tilt = 0.1F * random.uniform();
      planes.insert(planes.end(), {tilt, 0, -std::sqrt(1 - tilt * tilt), 1 + 0.02F * random.uniform()});
      weights.push_back(i % 5 == 0 ? 0 : random.uniform());
      intensity.push_back(random.uniform());
    }
    for (int i = 0; i < kColumns * 6; ++i) {
      for (int axis = 0; axis < 4; ++axis) {
        positions.push_back(i % 7 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.04F * random.uniform());
      }
    }
  }
  FusionImages images() const {
    return {planes.data(),
            weights.data(),
            intensity.data(),
            positions.data(),
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

constexpr std::size_t kSide = WarpedBrick::kSide;
using Values = std::array<float, kSide * kSide * kSide>;

void fuse_plainly(const FusionImages& view, const WarpedBrick& brick, Values& distance, Values& weight,
                  Values& intensity) {
  for (std::size_t i = 0; i < distance.size(); ++i) {
    const std::array<std::size_t, 3> voxel = {i % kSide, i / kSide % kSide, i / (kSide * kSide)};
    std::array<double, 3> p{};
    for (std::size_t corner = 0; corner < 8; ++corner) {
      double share = 1;
      std::size_t index = 0;
      for (std::size_t axis = 3; axis-- > 0;) {
        const std::size_t step = corner >> axis & 1U;
        const double along = static_cast<double>(voxel[axis] % 4) / 4;
        share *= step != 0 ? along : 1 - along;
        index = index * BrickCorners::kAlong + voxel[axis] / 4 + step;
      }
      for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += share * brick.corners.at(axis, index);
    }
    if (!(p[2] > view.nearest)) continue;
    const double u = std::floor(view.fx * p[0] / p[2] + view.cx + 0.5);
    const double v = std::floor(view.fy * p[1] / p[2] + view.cy + 0.5);
    if (!(u >= 0 && v >= 0 && u < view.width && v < view.height)) continue;
    const auto pixel = static_cast<std::size_t>(v * view.width + u);
    const float* plane = view.planes + 4 * pixel;
    const double off = plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] + plane[3];
    if (!(view.weights[pixel] > 0) || std::abs(off) >= view.truncation) continue;
    const float* position = view.positions + 4 * static_cast<std::size_t>(std::floor(v / view.stride) * view.columns +
                                                                          std::floor(u / view.stride));
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double apart = position[axis] - (brick.first[axis] + static_cast<float>(voxel[axis]) * brick.voxel);
      squared += apart * apart;
    }
    if (!(squared < view.reach * view.reach)) continue;
    const double trust = off < 0 ? 1 + off / view.truncation : 1;
    const double added = view.weights[pixel] * trust * trust;
    const double share = added / (weight[i] + added);
    distance[i] += static_cast<float>(share * (off - distance[i]));
    intensity[i] += static_cast<float>(share * (view.intensity[pixel] - intensity[i]));
    weight[i] = static_cast<float>(std::min<double>(weight[i] + added, view.max_weight));
  }
}

WarpedBrick brick_at(const std::array<float, 3>& position, float side, float deviation, Random& random) {
  WarpedBrick brick{};
  brick.voxel = 0.005F;
  for (std::size_t corner = 0; corner < BrickCorners::kCount; ++corner) {
    const std::array<std::size_t, 3> at = {corner % 3, corner / 3 % 3, corner / 9};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      brick.corners.at(axis, corner) =
          position[axis] + 0.5F * side * static_cast<float>(at[axis]) + deviation * random.uniform();
    }
  }
  return brick;
}

class WarpedBrickOnEveryInstructionSet : public OnEveryInstructionSet {};

TEST_P(WarpedBrickOnEveryInstructionSet, IsFusedAsByAPlainLoop) {
  Random random(5);
  const View view(random);
  std::size_t taught = 0;
  std::size_t different = 0; // on the edge of a pixel, or of what is near
  for (int round = 0; round < 100; ++round) {
    WarpedBrick brick =
        brick_at({0.8F * (random.uniform() - 0.5F), 0.5F * (random.uniform() - 0.5F), 0.95F + 0.06F * random.uniform()},
                 0.04F, 0.005F, random);
    if (round % 3 == 0) brick.corners.at(2, random.below(BrickCorners::kCount)) = std::nanf("");
    for (float& along : brick.first) along = 0.02F * random.uniform();
    Values distance{}, weight{}, intensity{};
    for (std::size_t i = 0; i < weight.size(); ++i) {
      weight[i] = round % 3 == 0 ? 0 : 5 * random.uniform();
      distance[i] = 0.03F * random.uniform();
    }
    Values distances = distance, weights = weight, intensities = intensity;
    fuse_brick(view.images(), brick, distance.data(), weight.data(), intensity.data());
    fuse_plainly(view.images(), brick, distances, weights, intensities);
    for (std::size_t i = 0; i < weight.size(); ++i) {
      if (intensities[i] != 0) ++taught;
      const bool is_same = std::abs(distance[i] - distances[i]) < 1e-6 && std::abs(weight[i] - weights[i]) < 1e-4 &&
                           std::abs(intensity[i] - intensities[i]) < 1e-4;
      if (!is_same) ++different;
    }
  }
  EXPECT_GT(taught, 3000U);
  EXPECT_LT(1000 * different, taught);
}

TEST_P(WarpedBrickOnEveryInstructionSet, LearnsNothingWhereverItMayBe) {
  Random random(6);
  const View view(random);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  constexpr float kFar = std::numeric_limits<float>::max();
  for (const std::array<float, 3>& position :
       {std::array{0.0F, 0.0F, -1.0F}, std::array{0.0F, 0.0F, 0.0F}, std::array{kFar, kFar, 1.0F},
        std::array{-kFar, 0.0F, kFar}, std::array{kNone, kNone, kNone}, std::array{0.0F, 0.0F, 2.0F}}) {
    const WarpedBrick brick = brick_at(position, 0, 0, random);
    Values distance{}, weight{}, intensity{};
    fuse_brick(view.images(), brick, distance.data(), weight.data(), intensity.data());
    EXPECT_EQ(weight, Values{});
    EXPECT_EQ(distance, Values{});
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, WarpedBrickOnEveryInstructionSet, every_instruction_set(), name_of_set);

} // namespace
} // namespace kinora::tracking
