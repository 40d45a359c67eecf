// Fusing into a TsdfVolume that bends.
// Source: Newcombe, Fox, Seitz, "DynamicFusion", CVPR 2015, sec. 3.2.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "tracking/tsdf/tsdf.h"
#include "tracking/tsdf/warped_brick.h"
#include "tracking/view/visibility.h"

namespace kinora::tracking {
namespace {

constexpr int kSide = TsdfVolume::kBrickSide;
constexpr std::size_t kCorners = BrickCorners::kAlong;
constexpr std::size_t kCell = kSide / (kCorners - 1); // voxels between two places where the bending is taken
constexpr std::size_t kCentre = BrickCorners::kCount / 2;
static_assert(kSide == static_cast<int>(WarpedBrick::kSide));
constexpr std::size_t kBricksPerChunk = 16;

std::uint64_t hash_of(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  std::uint64_t key = 0;
  for (const int number : {a.x(), a.y(), a.z(), b.x(), b.y(), b.z()}) {
    key = mix64(key ^ static_cast<std::uint32_t>(number));
  }
  return key;
}

BrickCorners corners_of(const Eigen::Vector3f& first, float voxel) {
  BrickCorners corners{};
  for (std::size_t i = 0; i < BrickCorners::kCount; ++i) {
    const std::array<std::size_t, 3> at = {i % kCorners, i / kCorners % kCorners, i / (kCorners * kCorners)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      corners.at(axis, i) = (first[static_cast<Eigen::Index>(axis)] + static_cast<float>(kCell * at[axis])) * voxel;
    }
  }
  return corners;
}

} // namespace

struct TsdfVolume::WarpedView {
  const BrickWarp& to_camera;
  FusionImages images;

  // Distance of a point of the camera from the plane that its pixel has measured; nothing where there is none.
  std::optional<float> distance(const Eigen::Vector3f& p) const {
    if (!(p.z() > images.nearest)) return std::nullopt;
    const float x = images.fx * p.x() / p.z() + images.cx + 0.5F;
    const float y = images.fy * p.y() / p.z() + images.cy + 0.5F;
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(images.width) && y < static_cast<float>(images.height))) {
      return std::nullopt;
    }
    const std::size_t pixel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(images.width) + static_cast<std::size_t>(x);
    if (!(images.weights[pixel] > 0)) return std::nullopt;
    const float* plane = images.planes + 4 * pixel;
    return plane[0] * p.x() + plane[1] * p.y() + plane[2] * p.z() + plane[3];
  }
};

// Makes the bricks within the truncation of the surface that is shown; returns a mark for each that comes within
// `reach` (metres, not less) of it: no voxel of another learns anything.
std::vector<std::uint8_t> TsdfVolume::touch_around(const CanonicalMap& positions, float reach) {
  struct Range {
    Eigen::Vector3i first = Eigen::Vector3i::Zero();
    Eigen::Vector3i last = Eigen::Vector3i::Constant(-1);
    bool operator==(const Range&) const = default;
    bool contains(const Eigen::Vector3i& at) const {
      return (at.array() >= first.array()).all() && (at.array() <= last.array()).all();
    }
  };
  const float brick_size = static_cast<float>(kSide * config_.voxel_size);
  const auto within = [&](const Eigen::Vector3f& position, float distance) {
    return Range{((position.array() - distance) / brick_size).floor().cast<int>(),
                 ((position.array() + distance) / brick_size).floor().cast<int>()};
  };
  std::vector<std::uint8_t> allocated(bricks_.size(), 0);
  std::vector<std::array<Range, 2>> done(256); // the last of each slot: places side by side have the same ranges
  for (std::size_t i = 0; i < positions.of_cell.pixel_count(); ++i) {
    const Eigen::Vector3f position = Eigen::Map<const Eigen::Vector3f>(positions.of_cell.data() + 4 * i);
    if (std::isnan(position.x())) continue;
    const std::array<Range, 2> ranges{within(position, static_cast<float>(config_.truncation)),
                                      within(position, reach)};
    const auto& [near, all] = ranges;
    std::array<Range, 2>& before = done[hash_of(ranges[1].first, ranges[0].first) % done.size()];
    if (ranges == before) continue;
    before = ranges;
    for (int z = all.first.z(); z <= all.last.z(); ++z) {
      for (int y = all.first.y(); y <= all.last.y(); ++y) {
        for (int x = all.first.x(); x <= all.last.x(); ++x) {
          const std::int32_t found = near.contains({x, y, z}) ? find_or_insert({x, y, z}) : find({x, y, z});
          if (found < 0) continue;
          allocated.resize(bricks_.size(), 0);
          allocated[static_cast<std::size_t>(found)] = 1;
        }
      }
    }
  }
  return allocated;
}

void TsdfVolume::update_warped(std::size_t number, const WarpedView& view) {
  Brick& brick = *bricks_[number];
  const float voxel = static_cast<float>(config_.voxel_size);
  const Eigen::Vector3f first(static_cast<float>(brick.coordinate[0] * kSide),
                              static_cast<float>(brick.coordinate[1] * kSide),
                              static_cast<float>(brick.coordinate[2] * kSide));
  WarpedBrick warped{{}, {first.x() * voxel, first.y() * voxel, first.z() * voxel}, voxel};
  view.to_camera(number, corners_of(first, voxel), warped.corners);
  const Eigen::Vector3f centre(warped.corners.at(0, kCentre), warped.corners.at(1, kCentre),
                               warped.corners.at(2, kCentre));
  // Far from what is measured, no voxel of the brick comes within the truncation.
  const float far = 2 * (view.images.truncation + static_cast<float>(kSide) * voxel);
  if (!centre.allFinite() || std::abs(view.distance(centre).value_or(0)) > far) return;
  fuse_brick(view.images, warped, brick.distance.data(), brick.weight.data(), brick.intensity.data());
}

std::vector<std::uint8_t> TsdfVolume::integrate_non_rigid(const DepthPlanes& view, const Image<float>& intensity,
                                                          const Intrinsics& intrinsics, const BrickWarp& to_camera,
                                                          const CanonicalMap& positions,
                                                          std::span<const std::uint8_t> skipped) {
  const bool fits = view.planes.width() == intrinsics.width && view.planes.height() == intrinsics.height &&
                    view.weights.same_size(view.planes) && (intensity.empty() || intensity.same_size(view.planes)) &&
                    positions.stride > 0 && positions.of_cell.channels() == 4 &&
                    positions.of_cell.width() * positions.stride >= intrinsics.width &&
                    positions.of_cell.height() * positions.stride >= intrinsics.height;
  if (!fits) {
    throw Error(ErrorCode::kFailure, "the images to fuse differ in size from each other or from their camera");
  }
  // Half a cell of pixels is about as wide as a voxel; a grazing surface is longer.
  const float reach = static_cast<float>(config_.truncation + 3 * config_.voxel_size);
  std::vector<std::uint8_t> allocated = touch_around(positions, reach);
  for (std::size_t i = 0; i < std::min(allocated.size(), skipped.size()); ++i) {
    if (skipped[i] != 0) allocated[i] = 0;
  }
  const WarpedView local{to_camera,
                         {view.planes.data(), view.weights.data(), intensity.empty() ? nullptr : intensity.data(),
                          positions.of_cell.data(), intrinsics.width, intrinsics.height, positions.stride,
                          positions.of_cell.width(), static_cast<float>(intrinsics.fx),
                          static_cast<float>(intrinsics.fy), static_cast<float>(intrinsics.cx),
                          static_cast<float>(intrinsics.cy), static_cast<float>(kNearestDepth),
                          static_cast<float>(config_.truncation), reach, config_.max_weight}};
  parallel_for(bricks_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      if (allocated[i] != 0) update_warped(i, local);
    }
  });
  return allocated;
}

} // namespace kinora::tracking
