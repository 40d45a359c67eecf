#include "motion/skinning/node_rows.h"

namespace kinora::motion {
namespace {

TransformRow row_of(const DualQuaternion& transform) {
  TransformRow row{};
  Eigen::Map<Eigen::Vector4f>(row.real.data()) = transform.real.coeffs().cast<float>();
  Eigen::Map<Eigen::Vector4f>(row.dual.data()) = transform.dual.coeffs().cast<float>();
  return row;
}

} // namespace

std::vector<TransformRow> transform_rows(std::span<const DualQuaternion> transforms) {
  std::vector<TransformRow> rows;
  rows.reserve(transforms.size());
  for (const DualQuaternion& transform : transforms) rows.push_back(row_of(transform));
  return rows;
}

std::vector<TransformRow> transform_rows(std::span<const DualQuaternion> transforms, const Eigen::Vector3d& from_origin,
                                         const Eigen::Vector3d& to_origin) {
  std::vector<TransformRow> rows;
  rows.reserve(transforms.size());
  for (const DualQuaternion& transform : transforms) {
    SE3 relative = transform.to_se3();
    relative.translation() += relative.linear() * from_origin - to_origin;
    rows.push_back(row_of(DualQuaternion::from(relative)));
  }
  return rows;
}

PositionRow position_row(const Eigen::Vector3d& position) {
  const Eigen::Vector3f single = position.cast<float>();
  return {single.x(), single.y(), single.z(), 0};
}

std::vector<PositionRow> position_rows(std::span<const Eigen::Vector3d> positions, const Eigen::Vector3d& origin) {
  std::vector<PositionRow> rows;
  rows.reserve(positions.size());
  for (const Eigen::Vector3d& position : positions) rows.push_back(position_row(position - origin));
  return rows;
}

} // namespace kinora::motion
