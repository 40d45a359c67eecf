// Carrying a TsdfVolume over to another canonical pose.
#include "core/parallel.h"
#include "tracking/tsdf/tsdf.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kSide = TsdfVolume::kBrickSide;
constexpr std::size_t kBricksPerChunk = 16;
static_assert(TsdfVolume::kBrickVoxels % motion::PointLanes::kPoints == 0);

} // namespace

void TsdfVolume::make_bricks(std::span<const SurfacePoint> surface) {
  const auto reach = static_cast<float>(config_.truncation);
  const auto brick_size = static_cast<float>(this->brick_size());
  for (const SurfacePoint& point : surface) {
    const Eigen::Vector3i first = ((point.position.array() - reach) / brick_size).floor().cast<int>();
    const Eigen::Vector3i last = ((point.position.array() + reach) / brick_size).floor().cast<int>();
    for (int z = first.z(); z <= last.z(); ++z) {
      for (int y = first.y(); y <= last.y(); ++y) {
        for (int x = first.x(); x <= last.x(); ++x) find_or_insert({x, y, z});
      }
    }
  }
}

void TsdfVolume::resample(const TsdfVolume& other, const PointWarp& to_other) {
  const auto voxel = static_cast<float>(config_.voxel_size);
  parallel_for(bricks_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    motion::PointLanes points{};
    motion::PointLanes positions{};
    for (std::size_t b = chunk.begin; b < chunk.end; ++b) {
      Brick& brick = *bricks_[b];
      for (std::size_t first = 0; first < kBrickVoxels; first += motion::PointLanes::kPoints) {
        for (std::size_t i = 0; i < motion::PointLanes::kPoints; ++i) {
          const std::array<std::size_t, 3> at = {(first + i) % kSide, (first + i) / kSide % kSide,
                                                 (first + i) / (kSide * kSide)};
          for (std::size_t axis = 0; axis < 3; ++axis) {
            points.along[axis][i] =
                (static_cast<float>(brick.coordinate[axis] * kBrickSide) + static_cast<float>(at[axis])) * voxel;
          }
        }
        to_other(b, points, positions);
        for (std::size_t i = 0; i < motion::PointLanes::kPoints; ++i) {
          const Eigen::Vector3d position = positions.at(i).cast<double>();
          if (position.allFinite()) other.read(position, brick, first + i);
        }
      }
    }
  });
}

} // namespace kinora::tracking
