#include "tracking/deforming/pose_database.h"

#include <cmath>

namespace kinora::tracking {
namespace {

constexpr std::size_t kComparedAtFirst = 48; // nodes

// Root mean square of the angles between the turns of nodes that both have.
double distance(const PoseDatabase::Entry& a, const PoseDatabase::Entry& b) {
  const std::size_t count = std::min(a.rotations.size(), b.rotations.size());
  if (count == 0) return 0;
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 2 * std::acos(std::min(1.0, std::abs(a.rotations[i].dot(b.rotations[i]))));
    sum += angle * angle;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

} // namespace

void PoseDatabase::add(std::size_t frame, const SE3& world_to_camera, std::span<const SE3> nodes) {
  if (nodes.empty()) return;
  if (stride_ == 0) stride_ = std::max<std::size_t>(1, nodes.size() / kComparedAtFirst);
  Entry entry{frame, world_to_camera, {}};
  for (std::size_t n = 0; n < nodes.size(); n += stride_) {
    entry.rotations.emplace_back(Eigen::Matrix3d(world_to_camera.linear() * nodes[n].linear()));
  }
  entries_.add(std::move(entry), distance);
}

} // namespace kinora::tracking
