// Where a layer carries what it holds while that is not seen: a box behind somebody's back is where the hand is.
// Source: Umeyama, "Least-Squares Estimation of Transformation Parameters Between Two Point Patterns", PAMI 13(4),
// 1991.
#include <Eigen/Geometry>

#include "tracking/deforming_tracker.h"

namespace kinora::tracking {
namespace {

constexpr double kMostlySeen = 0.5;
constexpr double kArm = 0.03; // metres, from a node to the points that stand for its turn

} // namespace

std::optional<SE3> DeformingTracker::carried(int label) const {
  const auto met = met_.find(label);
  if (met == met_.end() || seen_.empty()) return std::nullopt;
  std::vector<std::size_t> seen;
  std::vector<std::size_t> on_limbs;
  const std::size_t known = std::min(records_[met->second].nodes.size(), seen_.size());
  for (std::size_t n = 0; n < known; ++n) {
    if (!interaction_.holds(n, label)) continue;
    const auto limb = body_.limb_of(n);
    if (seen_[n] > kMostlySeen) seen.push_back(n);
    if (limb && body_.shows(*limb)) on_limbs.push_back(n);
  }
  const std::vector<std::size_t>& holding = seen.empty() ? on_limbs : seen;
  if (holding.empty()) return std::nullopt;
  Eigen::Matrix3Xd before(3, 4 * static_cast<Eigen::Index>(holding.size()));
  Eigen::Matrix3Xd after = before;
  Eigen::Index column = 0;
  for (const std::size_t n : holding) {
    for (int axis = -1; axis < 3; ++axis, ++column) {
      Eigen::Vector3d point = nodes_[n];
      if (axis >= 0) point[axis] += kArm;
      before.col(column) = volume_->origin() + records_[met->second].nodes[n] * point;
      after.col(column) = volume_->origin() + records_.back().nodes[n] * point;
    }
  }
  return renormalized(SE3(Eigen::umeyama(before, after, false)));
}

} // namespace kinora::tracking
