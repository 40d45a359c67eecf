// Fusing into a TsdfVolume that bends.
// Source: Newcombe, Fox, Seitz, "DynamicFusion", CVPR 2015, sec. 3.2.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "tracking/tsdf.h"

namespace kinora::tracking {
namespace {

constexpr int kSide = TsdfVolume::kBrickSide;
constexpr int kCell = 4;                    // voxels between two places where the bending is taken
constexpr int kCorners = kSide / kCell + 1; // of them along a brick's side
constexpr std::size_t kBricksPerChunk = 16;
constexpr float kNearest = 0.05F; // metres before the camera

} // namespace

struct TsdfVolume::BentView {
  const DepthPlanes& planes;
  const Image<float>& intensity;
  const Intrinsics& intrinsics;
  const Bending& to_camera;
  const Places& places;
  float reach; ///< metres, between a voxel and the place that its pixel shows

  /// Pixel that a point of the camera falls on; false if none.
  bool project(const Eigen::Vector3f& p, int& u, int& v) const {
    if (!(p.z() > kNearest)) return false;
    const float x = static_cast<float>(intrinsics.fx) * p.x() / p.z() + static_cast<float>(intrinsics.cx) + 0.5F;
    const float y = static_cast<float>(intrinsics.fy) * p.y() / p.z() + static_cast<float>(intrinsics.cy) + 0.5F;
    if (!(x >= 0 && y >= 0 && x < static_cast<float>(intrinsics.width) && y < static_cast<float>(intrinsics.height))) {
      return false;
    }
    u = static_cast<int>(x);
    v = static_cast<int>(y);
    return true;
  }

  /// Whether the pixel shows the surface about a place of the volume, and not another that is in front of it now.
  bool shows(const Eigen::Vector3f& place, int u, int v) const {
    const float* shown = places.of_cell.pixel(u / places.stride, v / places.stride);
    return (Eigen::Vector3f(shown[0], shown[1], shown[2]) - place).squaredNorm() < reach * reach; // false for NaN
  }

  float distance(const Eigen::Vector3f& p, int u, int v) const {
    const float* plane = planes.planes.pixel(u, v);
    return plane[0] * p.x() + plane[1] * p.y() + plane[2] * p.z() + plane[3];
  }
};

// The bricks that reach into the truncation about a surface.
void TsdfVolume::touch_around(const Places& places) {
  const float brick_size = static_cast<float>(kSide * config_.voxel_size);
  const float reach = static_cast<float>(config_.truncation) / brick_size;
  for (std::size_t i = 0; i < places.of_cell.pixel_count(); ++i) {
    const float* place = places.of_cell.data() + 3 * i;
    if (std::isnan(place[0])) continue;
    const Eigen::Vector3f local = Eigen::Vector3f(place[0], place[1], place[2]) / brick_size;
    const Eigen::Vector3i first = (local.array() - reach).floor().cast<int>();
    const Eigen::Vector3i last = (local.array() + reach).floor().cast<int>();
    for (int z = first.z(); z <= last.z(); ++z) {
      for (int y = first.y(); y <= last.y(); ++y) {
        for (int x = first.x(); x <= last.x(); ++x) find_or_insert({x, y, z});
      }
    }
  }
}

void TsdfVolume::update_bent(Brick& brick, const BentView& view) const {
  const float voxel = static_cast<float>(config_.voxel_size);
  const float truncation = static_cast<float>(config_.truncation);
  const Eigen::Vector3f first(static_cast<float>(brick.coordinate[0] * kSide),
                              static_cast<float>(brick.coordinate[1] * kSide),
                              static_cast<float>(brick.coordinate[2] * kSide));
  const auto centre = view.to_camera((first + Eigen::Vector3f::Constant(0.5F * kSide)) * voxel);
  int u = 0;
  int v = 0;
  if (!centre) return;
  // Far from what is measured, no voxel of the brick comes within the truncation.
  if (view.project(*centre, u, v) && view.planes.weights.at(u, v) > 0 &&
      std::abs(view.distance(*centre, u, v)) > 2 * (truncation + static_cast<float>(kSide) * voxel)) {
    return;
  }
  std::array<std::optional<Eigen::Vector3f>, static_cast<std::size_t>(kCorners * kCorners * kCorners)> corners;
  const auto corner = [&](int x, int y, int z) -> std::optional<Eigen::Vector3f>& {
    return corners[static_cast<unsigned>((z * kCorners + y) * kCorners + x)];
  };
  for (int z = 0; z < kCorners; ++z) {
    for (int y = 0; y < kCorners; ++y) {
      for (int x = 0; x < kCorners; ++x) {
        const Eigen::Vector3f at(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
        corner(x, y, z) = view.to_camera((first + kCell * at) * voxel);
      }
    }
  }
  std::size_t i = 0;
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x, ++i) {
        Eigen::Vector3f p = Eigen::Vector3f::Zero();
        bool whole = true;
        for (int c = 0; c < 8 && whole; ++c) {
          const int cx = c & 1;
          const int cy = (c >> 1) & 1;
          const int cz = c >> 2;
          const auto& at = corner(x / kCell + cx, y / kCell + cy, z / kCell + cz);
          const float fx = static_cast<float>(x % kCell) / kCell;
          const float fy = static_cast<float>(y % kCell) / kCell;
          const float fz = static_cast<float>(z % kCell) / kCell;
          const float share = (cx != 0 ? fx : 1 - fx) * (cy != 0 ? fy : 1 - fy) * (cz != 0 ? fz : 1 - fz);
          whole = at.has_value();
          if (whole) p += share * *at;
        }
        if (!whole || !view.project(p, u, v)) continue;
        float weight = view.planes.weights.at(u, v);
        if (weight <= 0) continue;
        const float distance = view.distance(p, u, v);
        if (std::abs(distance) >= truncation) continue;
        const Eigen::Vector3f inside(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
        if (!view.shows((first + inside) * voxel, u, v)) continue;
        if (distance < 0) {
          const float trust = 1.0F + distance / truncation;
          weight *= trust * trust;
        }
        const float old = brick.weight[i];
        const float share = weight / (old + weight);
        brick.distance[i] += share * (distance - brick.distance[i]);
        if (!view.intensity.empty()) brick.intensity[i] += share * (view.intensity.at(u, v) - brick.intensity[i]);
        brick.weight[i] = std::min(old + weight, config_.max_weight);
      }
    }
  }
}

void TsdfVolume::integrate_bent(const DepthPlanes& view, const Image<float>& intensity, const Intrinsics& intrinsics,
                                const Bending& to_camera, const Places& places) {
  const bool fits = view.planes.width() == intrinsics.width && view.planes.height() == intrinsics.height &&
                    view.weights.same_size(view.planes) && (intensity.empty() || intensity.same_size(view.planes)) &&
                    places.stride > 0 && places.of_cell.channels() == 3 &&
                    places.of_cell.width() * places.stride >= intrinsics.width &&
                    places.of_cell.height() * places.stride >= intrinsics.height;
  if (!fits) {
    throw Error(ErrorCode::kFailure, "the images to fuse differ in size from each other or from their camera");
  }
  touch_around(places);
  // Half a cell of pixels is about as wide as a voxel; a grazing surface is longer.
  const float reach = static_cast<float>(config_.truncation + 3 * config_.voxel_size);
  const BentView local{view, intensity, intrinsics, to_camera, places, reach};
  parallel_for(bricks_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) update_bent(*bricks_[i], local);
  });
}

} // namespace kinora::tracking
