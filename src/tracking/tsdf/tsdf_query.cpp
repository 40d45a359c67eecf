// Reading a TsdfVolume: interpolation.
#include <algorithm>
#include <cmath>

#include "tracking/tsdf/tsdf.h"

namespace kinora::tracking {
namespace {

constexpr int kSide = TsdfVolume::kBrickSide;

using Index3 = std::array<int, 3>;

} // namespace

/// Voxels around a base voxel; each brick that is needed is looked up once.
struct TsdfVolume::Neighbourhood {
  const TsdfVolume& volume;
  Index3 base_brick;
  std::array<const Brick*, 27> bricks{};
  std::array<bool, 27> looked_up{};

  Neighbourhood(const TsdfVolume& owner, const Index3& voxel)
      : volume(owner), base_brick{voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3} {}

  /// The brick of a voxel at most one brick away from the base, or nullptr; `inside` receives the index in it.
  const Brick* brick_of(const Index3& voxel, std::size_t& inside) {
    const Index3 c = {voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3};
    const int index = ((voxel[2] & 7) * kSide + (voxel[1] & 7)) * kSide + (voxel[0] & 7);
    inside = static_cast<std::size_t>(index);
    const int neighbour = ((c[2] - base_brick[2] + 1) * 3 + c[1] - base_brick[1] + 1) * 3 + c[0] - base_brick[0] + 1;
    const auto slot = static_cast<std::size_t>(neighbour);
    if (!looked_up[slot]) {
      looked_up[slot] = true;
      const std::int32_t found = volume.find(c);
      bricks[slot] = found < 0 ? nullptr : volume.bricks_[static_cast<std::size_t>(found)].get();
    }
    return bricks[slot];
  }

  /// Trilinear value of one of a brick's arrays; false where a corner was never seen.
  bool interpolate(const Eigen::Vector3d& grid, const std::array<float, kBrickVoxels> Brick::*values, double& result) {
    const Index3 cell = {static_cast<int>(std::floor(grid.x())), static_cast<int>(std::floor(grid.y())),
                         static_cast<int>(std::floor(grid.z()))};
    const Eigen::Vector3d f = grid - Eigen::Vector3d(cell[0], cell[1], cell[2]);
    result = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const int dx = corner & 1;
      const int dy = (corner >> 1) & 1;
      const int dz = corner >> 2;
      std::size_t inside = 0;
      const Brick* brick = brick_of({cell[0] + dx, cell[1] + dy, cell[2] + dz}, inside);
      if (brick == nullptr || brick->weight[inside] <= 0) return false;
      const double weight =
          (dx != 0 ? f.x() : 1 - f.x()) * (dy != 0 ? f.y() : 1 - f.y()) * (dz != 0 ? f.z() : 1 - f.z());
      result += weight * (brick->*values)[inside];
    }
    return true;
  }

  /// Derivative per voxel along one axis: central if both sides are seen, else one-sided, else nothing.
  bool derivative(const Eigen::Vector3d& grid, int axis, double here, double& result) {
    double ahead = 0;
    double behind = 0;
    const Eigen::Vector3d step = Eigen::Vector3d::Unit(axis);
    const bool has_ahead = interpolate(grid + step, &Brick::distance, ahead);
    const bool has_behind = interpolate(grid - step, &Brick::distance, behind);
    if (has_ahead && has_behind) {
      result = 0.5 * (ahead - behind);
    } else if (has_ahead) {
      result = ahead - here;
    } else if (has_behind) {
      result = here - behind;
    }
    return has_ahead || has_behind;
  }

  std::optional<TsdfSample> sample(const Eigen::Vector3d& grid) {
    TsdfSample result{0, Eigen::Vector3d::Zero()};
    if (!interpolate(grid, &Brick::distance, result.distance)) return std::nullopt;
    for (int axis = 0; axis < 3; ++axis) {
      if (!derivative(grid, axis, result.distance, result.normal[axis])) return std::nullopt;
    }
    const double length = result.normal.norm();
    if (length < 1e-12) return std::nullopt;
    result.normal /= length;
    return result;
  }
};

namespace {

// Bricks' coordinates are kept to 21 bits an axis.
bool is_addressable(const Eigen::Vector3d& grid) { return (grid.array().abs() < 8e6).all(); }

Index3 base_voxel(const Eigen::Vector3d& grid) {
  return {static_cast<int>(std::floor(grid.x())), static_cast<int>(std::floor(grid.y())),
          static_cast<int>(std::floor(grid.z()))};
}

} // namespace

std::optional<double> TsdfVolume::distance(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d grid = to_grid(point);
  if (!is_addressable(grid)) return std::nullopt;
  double result = 0;
  return Neighbourhood(*this, base_voxel(grid)).interpolate(grid, &Brick::distance, result) ? std::optional(result)
                                                                                            : std::nullopt;
}

std::optional<double> TsdfVolume::intensity(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d grid = to_grid(point);
  if (!is_addressable(grid)) return std::nullopt;
  double result = 0;
  return Neighbourhood(*this, base_voxel(grid)).interpolate(grid, &Brick::intensity, result) ? std::optional(result)
                                                                                             : std::nullopt;
}

void TsdfVolume::read(const Eigen::Vector3d& position, Brick& brick, std::size_t voxel) const {
  const Eigen::Vector3d grid = position / config_.voxel_size;
  if (!is_addressable(grid)) return;
  Neighbourhood around(*this, base_voxel(grid));
  double weight = 0;
  double distance = 0;
  double intensity = 0;
  if (!around.interpolate(grid, &Brick::weight, weight) || !around.interpolate(grid, &Brick::distance, distance) ||
      !around.interpolate(grid, &Brick::intensity, intensity)) {
    return;
  }
  brick.weight[voxel] = static_cast<float>(weight);
  brick.distance[voxel] = static_cast<float>(distance);
  brick.intensity[voxel] = static_cast<float>(intensity);
}

std::optional<TsdfSample> TsdfVolume::sample(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d grid = to_grid(point);
  if (!is_addressable(grid)) return std::nullopt;
  return Neighbourhood(*this, base_voxel(grid)).sample(grid);
}

} // namespace kinora::tracking
