#include "tracking/deformation_graph.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "core/random.h"

namespace kinora::tracking {
namespace {

long cell_of(double coordinate, double size) { return static_cast<long>(std::floor(coordinate / size)); }

bool nearer(const NearestPoints::Neighbour& a, const NearestPoints::Neighbour& b) {
  return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : a.index < b.index;
}

} // namespace

NearestPoints::NearestPoints(std::span<const Eigen::Vector3d> points, double reach)
    : reach_(reach), points_(points.begin(), points.end()) {
  const std::size_t slots = std::bit_ceil(std::max<std::size_t>(16, 2 * points_.size()));
  begin_.assign(slots + 1, 0);
  std::vector<std::uint32_t> slot(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector3d& p = points_[i];
    slot[i] =
        static_cast<std::uint32_t>(slot_of(cell_of(p.x(), reach_), cell_of(p.y(), reach_), cell_of(p.z(), reach_)));
    ++begin_[slot[i] + 1];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  order_.resize(points_.size());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < points_.size(); ++i) order_[next[slot[i]]++] = static_cast<std::uint32_t>(i);
}

std::size_t NearestPoints::slot_of(long x, long y, long z) const {
  const auto hash = mix64(static_cast<std::uint64_t>(x) * 0x9E3779B1U ^ mix64(static_cast<std::uint64_t>(y)) ^
                          mix64(mix64(static_cast<std::uint64_t>(z))));
  return hash & (begin_.size() - 2);
}

std::size_t NearestPoints::find(const Eigen::Vector3d& query, std::span<Neighbour> found) const {
  std::size_t count = 0;
  if (points_.empty() || found.empty() || !query.allFinite()) return 0;
  const long x = cell_of(query.x(), reach_);
  const long y = cell_of(query.y(), reach_);
  const long z = cell_of(query.z(), reach_);
  std::array<std::size_t, 27> looked{};
  std::size_t looked_count = 0;
  for (long dz = -1; dz <= 1; ++dz) {
    for (long dy = -1; dy <= 1; ++dy) {
      for (long dx = -1; dx <= 1; ++dx) {
        const std::size_t slot = slot_of(x + dx, y + dy, z + dz);
        // Two cells may share a slot: it is looked through once.
        if (std::find(looked.begin(), looked.begin() + static_cast<std::ptrdiff_t>(looked_count), slot) !=
            looked.begin() + static_cast<std::ptrdiff_t>(looked_count)) {
          continue;
        }
        looked[looked_count++] = slot;
        for (std::uint32_t k = begin_[slot]; k < begin_[slot + 1]; ++k) {
          const Neighbour candidate{static_cast<int>(order_[k]), (points_[order_[k]] - query).squaredNorm()};
          if (candidate.squared_distance > reach_ * reach_) continue;
          if (count == found.size() && !nearer(candidate, found[count - 1])) continue;
          std::size_t at = count < found.size() ? count++ : count - 1;
          for (; at > 0 && nearer(candidate, found[at - 1]); --at) found[at] = found[at - 1];
          found[at] = candidate;
        }
      }
    }
  }
  return count;
}

DeformationGraph::DeformationGraph(std::vector<Eigen::Vector3d> nodes, double weight_radius, double influence_radius)
    : weight_radius_(weight_radius), influence_radius_(influence_radius) {
  if (nodes.empty() || !(weight_radius > 0) || !(influence_radius > 0)) {
    throw Error(ErrorCode::kFailure, "a deformation graph needs nodes and positive radii");
  }
  nearest_ = NearestPoints(nodes, influence_radius);
}

Influence DeformationGraph::influence(const Eigen::Vector3d& canonical) const {
  std::array<NearestPoints::Neighbour, Influence::kMost + 1> found{};
  const std::size_t within_reach = nearest_.find(canonical, found);
  Influence result;
  result.count = static_cast<int>(std::min<std::size_t>(within_reach, Influence::kMost));
  if (result.count == 0) return result;
  // The first node that has no say takes its weight from the others: what moves a point changes without a jump.
  const double nearest = found[0].squared_distance;
  const double first_without = within_reach > Influence::kMost ? found[Influence::kMost].squared_distance
                                                               : influence_radius_ * influence_radius_;
  const auto weight = [&](double squared_distance) {
    return std::exp((nearest - squared_distance) / (weight_radius_ * weight_radius_));
  };
  double total = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(result.count); ++k) {
    result.nodes[k] = found[k].index;
    total += result.weights[k] = std::max(0.0, weight(found[k].squared_distance) - weight(first_without));
  }
  if (!(total > 0)) {
    result.count = 1;
    result.weights[0] = total = 1;
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(result.count); ++k) result.weights[k] /= total;
  return result;
}

} // namespace kinora::tracking
