#include "tracking/deforming/canonical_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/parallel.h"
#include "motion/skinning/skinned_lanes.h"

namespace kinora::tracking {
namespace {

constexpr int kStride = 4;
constexpr float kMinNormalCosine = 0.5F; // cosine
constexpr std::size_t kPointsPerChunk = 1024;
constexpr std::size_t kRowsPerChunk = 16; // of cells

struct PosedSurfacePoint {
  Eigen::Vector3f position;
  Eigen::Vector3f normal;
  int cell = -1;
};

} // namespace

TsdfVolume::CanonicalMap find_canonical_map(const LayerView& view, std::span<const SurfacePoint> surface,
                                            std::span<const motion::Influence> skin, const motion::NodeStates& states,
                                            double reach) {
  const int columns = (view.intrinsics.width + kStride - 1) / kStride;
  const int rows = (view.intrinsics.height + kStride - 1) / kStride;
  std::vector<PosedSurfacePoint> live(surface.size());
  const std::vector<motion::TransformRow> transforms = motion::transform_rows(states.transforms);
  parallel_for(surface.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    motion::PointLanes points{}, normals{}, positions, rotated;
    motion::InfluenceLanes influences{};
    for (std::size_t first = chunk.begin; first < chunk.end; first += motion::PointLanes::kPoints) {
      const std::size_t count = std::min(motion::PointLanes::kPoints, chunk.end - first);
      for (std::size_t i = 0; i < count; ++i) {
        points.set(i, surface[first + i].position);
        normals.set(i, surface[first + i].normal);
        influences.set(i, skin[first + i]);
      }
      motion::skin_points(transforms, influences, points, positions, normals, rotated);
      for (std::size_t i = 0; i < count; ++i) {
        const Eigen::Vector3f position = positions.at(i);
        const Eigen::Vector3f normal = rotated.at(i);
        if (!(position.z() > 0) || normal.dot(position) > 0) continue; // nothing moves it, or it looks away
        const Eigen::Vector2d pixel = view.intrinsics.project(position.cast<double>()) / kStride;
        if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < columns && pixel.y() < rows)) continue;
        live[first + i] = {position, normal, static_cast<int>(pixel.y()) * columns + static_cast<int>(pixel.x())};
      }
    }
  });
  // Of each cell the point that is nearest to the camera.
  std::vector<int> front(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), -1);
  for (std::size_t i = 0; i < live.size(); ++i) {
    if (live[i].cell < 0) continue;
    int& best = front[static_cast<std::size_t>(live[i].cell)];
    if (best < 0 || live[i].position.z() < live[static_cast<std::size_t>(best)].position.z())
      best = static_cast<int>(i);
  }
  TsdfVolume::CanonicalMap result{kStride, Image<float>(columns, rows, 4, std::numeric_limits<float>::quiet_NaN())};
  const auto fill_row = [&](int row) {
    for (int column = 0; column < columns; ++column) {
      const int u = std::min(kStride * column + kStride / 2, view.intrinsics.width - 1);
      const int v = std::min(kStride * row + kStride / 2, view.intrinsics.height - 1);
      if (view.planes.weights.at(u, v) <= 0) continue;
      const Eigen::Vector3d measured = view.point(u, v);
      const float* plane = view.planes.planes.pixel(u, v);
      const Eigen::Vector3f normal(plane[0], plane[1], plane[2]);
      float best = static_cast<float>(reach * reach);
      int nearest = -1;
      for (int y = std::max(0, row - 1); y <= std::min(rows - 1, row + 1); ++y) {
        for (int x = std::max(0, column - 1); x <= std::min(columns - 1, column + 1); ++x) {
          const int cell = y * columns + x;
          const int index = front[static_cast<std::size_t>(cell)];
          if (index < 0) continue;
          const PosedSurfacePoint& candidate = live[static_cast<std::size_t>(index)];
          const float squared = (candidate.position - measured.cast<float>()).squaredNorm();
          if (squared >= best || candidate.normal.dot(normal) < kMinNormalCosine) continue;
          best = squared;
          nearest = index;
        }
      }
      if (nearest < 0) continue;
      const SE3 to_camera = motion::blend_motion(states, skin[static_cast<std::size_t>(nearest)]).transform.to_se3();
      const Eigen::Vector3f position = (to_camera.inverse() * measured).cast<float>();
      std::copy_n(position.data(), 3, result.of_cell.pixel(column, row));
    }
  };
  parallel_for(static_cast<std::size_t>(rows), kRowsPerChunk, [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) fill_row(static_cast<int>(row));
  });
  return result;
}

} // namespace kinora::tracking
