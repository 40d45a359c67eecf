// The zero level of a TsdfVolume, as points on the voxel edges that it crosses.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "tracking/tsdf/tsdf.h"

namespace kinora::tracking {
namespace {

constexpr int kBrick = TsdfVolume::kBrickSide;
constexpr int kSide = kBrick + 4; // one voxel before the brick and three after it
constexpr std::size_t kVoxels = kSide * kSide * kSide;
constexpr std::array<std::size_t, 3> kStride = {1, kSide, kSide* kSide};
constexpr std::size_t kBricksPerChunk = 64;

} // namespace

/// Where the surface may be: beside voxels of more weight, and nearer to it.
struct TsdfVolume::Limits {
  float weight;
  float distance; ///< metres
};

/// A brick and what lies around it: all that the surface in the brick and its normals depend on, without looking any
/// voxel up.
struct TsdfVolume::Block {
  std::array<const Brick*, 27> bricks{};
  std::array<float, kVoxels> distance{};
  std::array<std::uint8_t, kVoxels> side{}; ///< kFront or kBehind, or 0 where no surface can be beside the voxel
  std::array<std::uint8_t, kVoxels> seen{}; ///< all eight corners of the cell that begins here

  static constexpr std::uint8_t kFront = 1;
  static constexpr std::uint8_t kBehind = 2;
  static constexpr std::uint64_t kEvery = 0x0101010101010101; ///< one in each of eight voxels

  Block(const TsdfVolume& volume, const Brick& centre, const Limits& limits) {
    for (int i = 0; i < 27; ++i) {
      const std::array<int, 3>& c = centre.coordinate;
      const std::int32_t found = volume.find({c[0] + i % 3 - 1, c[1] + i / 3 % 3 - 1, c[2] + i / 9 - 1});
      if (found >= 0) bricks[static_cast<std::size_t>(i)] = volume.bricks_[static_cast<std::size_t>(found)].get();
    }
    std::array<float, kVoxels> weight{};
    for (int z = -1; z < kBrick + 3; ++z) {
      for (int y = -1; y < kBrick + 3; ++y) {
        const std::size_t to = index(-1, y, z);
        copy_row(&Brick::distance, y, z, distance.data() + to);
        copy_row(&Brick::weight, y, z, weight.data() + to);
      }
    }
    for (std::size_t i = 0; i < kVoxels; ++i) {
      side[i] = side_of(distance[i], weight[i], limits);
      seen[i] = weight[i] > 0 ? 1 : 0;
    }
    for (const std::size_t stride : kStride) {
      for (std::size_t i = 0; i + stride < kVoxels; ++i) seen[i] &= seen[i + stride];
    }
  }

  // Without a branch, so that compilers vectorise the loops over it.
  static std::uint8_t side_of(float distance, float weight, const Limits& limits) {
    const int may_hold =
        static_cast<int>(weight > limits.weight) & static_cast<int>(std::abs(distance) <= limits.distance);
    return static_cast<std::uint8_t>(may_hold + (may_hold & static_cast<int>(distance < 0))); // kFront or kBehind
  }

  /// Of the eight voxels of a row: one in the byte of each whose edge along the axis crosses the surface.
  std::uint64_t crossings(std::size_t row, std::size_t axis) const {
    std::uint64_t here = 0;
    std::uint64_t there = 0;
    std::memcpy(&here, side.data() + row, sizeof here);
    std::memcpy(&there, side.data() + row + kStride[axis], sizeof there);
    const std::uint64_t differ = here ^ there;
    return differ & differ >> 1U & kEvery; // from front to behind: both bits
  }

  /// Of a voxel, counted from the brick's first; each from −1 to kBrick + 2.
  static std::size_t index(int x, int y, int z) {
    const int result = ((z + 1) * kSide + y + 1) * kSide + x + 1;
    return static_cast<std::size_t>(result);
  }
  const Brick* brick_at(int x, int y, int z) const {
    const int result = (((z >> 3) + 1) * 3 + (y >> 3) + 1) * 3 + (x >> 3) + 1;
    return bricks[static_cast<std::size_t>(result)];
  }
  static std::size_t inside(int x, int y, int z) {
    const int result = ((z & 7) * kBrick + (y & 7)) * kBrick + (x & 7);
    return static_cast<std::size_t>(result);
  }

  void copy_row(const std::array<float, kBrickVoxels> Brick::*values, int y, int z, float* to) const {
    const std::size_t first = inside(0, y, z);
    if (const Brick* before = brick_at(-1, y, z)) to[0] = (before->*values)[first + kBrick - 1];
    if (const Brick* middle = brick_at(0, y, z)) std::copy_n((middle->*values).data() + first, kBrick, to + 1);
    if (const Brick* after = brick_at(kBrick, y, z)) std::copy_n((after->*values).data() + first, 3, to + 1 + kBrick);
  }

  float intensity(int x, int y, int z) const { return brick_at(x, y, z)->intensity[inside(x, y, z)]; }
  float weight(int x, int y, int z) const { return brick_at(x, y, z)->weight[inside(x, y, z)]; }

  /// A point on a voxel edge: `fraction` of the way from a voxel along an axis.
  struct EdgePoint {
    std::size_t voxel;
    std::size_t stride; ///< of the axis
    double fraction;
  };

  /// False where a corner of the cell was never seen.
  bool interpolate(const EdgePoint& point, double& result) const {
    if (seen[point.voxel] == 0) return false;
    result = distance[point.voxel] * (1 - point.fraction) + distance[point.voxel + point.stride] * point.fraction;
    return true;
  }

  /// By central differences of ±1 voxel where both sides are seen, else one-sided; nothing without either.
  std::optional<Eigen::Vector3d> normal(const EdgePoint& point) const {
    double here = 0;
    if (!interpolate(point, here)) return std::nullopt;
    Eigen::Vector3d result;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double ahead = 0;
      double behind = 0;
      const bool has_ahead = interpolate({point.voxel + kStride[axis], point.stride, point.fraction}, ahead);
      const bool has_behind = interpolate({point.voxel - kStride[axis], point.stride, point.fraction}, behind);
      if (!has_ahead && !has_behind) return std::nullopt;
      result[static_cast<Eigen::Index>(axis)] = has_ahead && has_behind ? 0.5 * (ahead - behind)
                                                : has_ahead             ? ahead - here
                                                                        : here - behind;
    }
    const double length = result.norm();
    if (length < 1e-12) return std::nullopt;
    return result / length;
  }
};

// Whether a voxel edge that begins in the brick crosses the surface.
bool TsdfVolume::holds_surface(const Brick& brick, const Limits& limits) const {
  std::uint8_t sides = 0;
  for (std::size_t i = 0; i < kBrickVoxels; ++i) sides |= Block::side_of(brick.distance[i], brick.weight[i], limits);
  if (sides == 0) return false;
  constexpr std::uint8_t kBoth = Block::kFront | Block::kBehind;
  for (std::size_t axis = 0; sides != kBoth && axis < 3; ++axis) {
    std::array<int, 3> next = brick.coordinate;
    ++next[axis];
    const std::int32_t found = find(next);
    if (found < 0) continue;
    const Brick& beside = *bricks_[static_cast<std::size_t>(found)];
    for (int i = 0; i < kBrick * kBrick; ++i) {
      const std::array<int, 2> at = {i % kBrick, i / kBrick};
      const std::size_t voxel = axis == 0   ? Block::inside(0, at[0], at[1])
                                : axis == 1 ? Block::inside(at[0], 0, at[1])
                                            : Block::inside(at[0], at[1], 0);
      sides |= Block::side_of(beside.distance[voxel], beside.weight[voxel], limits);
    }
  }
  return sides == kBoth;
}

void TsdfVolume::append_surface(std::size_t number, float min_weight, std::vector<SurfacePoint>& points) const {
  const Brick& brick = *bricks_[number];
  const Limits limits{min_weight, 0.95F * static_cast<float>(config_.truncation)};
  if (!holds_surface(brick, limits)) return;
  const Block block(*this, brick, limits);
  const auto append = [&](const std::array<int, 3>& at, std::size_t axis) {
    const std::size_t here = Block::index(at[0], at[1], at[2]);
    const std::size_t there = here + kStride[axis];
    const float fraction = block.distance[here] / (block.distance[here] - block.distance[there]);
    const auto normal = block.normal(fraction < 1 ? Block::EdgePoint{here, kStride[axis], fraction}
                                                  : Block::EdgePoint{there, kStride[axis], 0});
    if (!normal) return;
    Eigen::Vector3d grid(brick.coordinate[0] * kBrick + at[0], brick.coordinate[1] * kBrick + at[1],
                         brick.coordinate[2] * kBrick + at[2]);
    grid[static_cast<Eigen::Index>(axis)] += fraction;
    std::array<int, 3> next = at;
    ++next[axis];
    const float intensity = block.intensity(at[0], at[1], at[2]);
    points.push_back({(grid * config_.voxel_size).cast<float>(), normal->cast<float>(),
                      intensity + fraction * (block.intensity(next[0], next[1], next[2]) - intensity),
                      std::min(block.weight(at[0], at[1], at[2]), block.weight(next[0], next[1], next[2])),
                      static_cast<std::uint32_t>(number)});
  };
  for (int z = 0; z < kBrick; ++z) {
    for (int y = 0; y < kBrick; ++y) {
      const std::size_t row = Block::index(0, y, z);
      const std::array<std::uint64_t, 3> crossings = {block.crossings(row, 0), block.crossings(row, 1),
                                                      block.crossings(row, 2)};
      std::uint64_t left = crossings[0] | crossings[1] | crossings[2];
      for (; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if ((crossings[axis] >> static_cast<unsigned>(bit) & 1U) != 0) append({bit / 8, y, z}, axis);
        }
      }
    }
  }
}

std::vector<SurfacePoint> TsdfVolume::surface_points(float min_weight) const {
  std::vector<std::vector<SurfacePoint>> parts(chunk_count(bricks_.size(), kBricksPerChunk));
  parallel_for(bricks_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) append_surface(i, min_weight, parts[chunk.index]);
  });
  std::vector<SurfacePoint> points;
  for (const std::vector<SurfacePoint>& part : parts) points.insert(points.end(), part.begin(), part.end());
  return points;
}

} // namespace kinora::tracking
