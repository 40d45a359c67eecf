#include "motion/skinning/node_candidates.h"

#include <array>
#include <cmath>

namespace kinora::motion {
namespace {

constexpr std::size_t kNearestNodes = Influence::kMax + 1;

// Whether node a is nearer than node b to every point of a cube: their squared distances differ by what is linear.
bool is_nearer_everywhere(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& centre,
                          double side) {
  return (a - centre).squaredNorm() - (b - centre).squaredNorm() + side * (a - b).lpNorm<1>() < 0;
}

} // namespace

NodeCandidates::NodeCandidates(const DeformationGraph& graph, double side)
    : side_(side), half_diagonal_(0.5 * std::sqrt(3.0) * side), reach_(graph.influence_radius() + half_diagonal_),
      nearest_(graph.nodes(), reach_) {}

void NodeCandidates::append(const Eigen::Vector3d& centre, std::vector<std::int32_t>& candidates) const {
  std::array<NearestPoints::Neighbour, kMax> found{};
  const std::size_t within_reach = nearest_.find(centre, found);
  for (std::size_t i = 0; i < within_reach; ++i) {
    const Eigen::Vector3d& node = nearest_.points()[static_cast<std::size_t>(found[i].index)];
    std::size_t nearer = 0;
    for (std::size_t k = 0; k < i && nearer < kNearestNodes; ++k) {
      const Eigen::Vector3d& other = nearest_.points()[static_cast<std::size_t>(found[k].index)];
      if (is_nearer_everywhere(other, node, centre, side_)) ++nearer;
    }
    if (nearer < kNearestNodes) candidates.push_back(found[i].index);
    if (i >= kNearestNodes && is_too_far(found[kNearestNodes - 1], found[i])) break;
  }
}

bool NodeCandidates::is_new_candidate(const Eigen::Vector3d& centre, std::int32_t node,
                                      std::span<const std::int32_t> candidates) const {
  const Eigen::Vector3d& position = nearest_.points()[static_cast<std::size_t>(node)];
  if ((position - centre).squaredNorm() > reach_ * reach_) return false;
  std::size_t nearer = 0;
  for (const std::int32_t candidate : candidates) {
    const Eigen::Vector3d& other = nearest_.points()[static_cast<std::size_t>(candidate)];
    if (is_nearer_everywhere(other, position, centre, side_) && ++nearer == kNearestNodes) return false;
  }
  return true;
}

// So are all that are still farther from the centre.
bool NodeCandidates::is_too_far(const NearestPoints::Neighbour& last, const NearestPoints::Neighbour& node) const {
  return std::sqrt(node.squared_distance) > std::sqrt(last.squared_distance) + 2 * half_diagonal_;
}

} // namespace kinora::motion
