// The nodes of a deformation graph as vectorised kernels read them (skinning_simd.h): rows of four numbers in single
// precision. The one packing of node transforms.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/dual_quaternion.h"

namespace kinora::motion {

/// A unit dual quaternion; real and dual part x y z w.
struct TransformRow {
  std::array<float, 4> real, dual;
};
static_assert(sizeof(TransformRow) == 32);

/// x y z 0, metres.
using PositionRow = std::array<float, 4>;

std::vector<TransformRow> transform_rows(std::span<const DualQuaternion> transforms);
/// The same between points relative to `from_origin` and points relative to `to_origin`: both near the nodes, so that
/// single precision does for what is far away.
std::vector<TransformRow> transform_rows(std::span<const DualQuaternion> transforms, const Eigen::Vector3d& from_origin,
                                         const Eigen::Vector3d& to_origin);

PositionRow position_row(const Eigen::Vector3d& position);
std::vector<PositionRow> position_rows(std::span<const Eigen::Vector3d> positions,
                                       const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

} // namespace kinora::motion
