#include "tracking/deforming/topology_change.h"

#include <array>
#include <cmath>

namespace kinora::tracking {
namespace {

constexpr std::size_t kMax = 32; // neighbours of a node that are looked at

bool are_separated(double distance, double squared_distance_there, double spacing, const TopologyChangeConfig& config) {
  const double apart = distance + config.apart * spacing;
  return squared_distance_there > apart * apart;
}

/// Pairs of nodes that are near each other in one pose and apart in another.
std::vector<std::array<std::size_t, 2>> separated_pairs(std::span<const Eigen::Vector3d> near,
                                                        std::span<const Eigen::Vector3d> apart, double spacing,
                                                        const TopologyChangeConfig& config) {
  std::vector<std::array<std::size_t, 2>> pairs;
  const motion::NearestPoints nearest(near, config.near * spacing);
  std::array<motion::NearestPoints::Neighbour, kMax> found{};
  for (std::size_t a = 0; a < near.size(); ++a) {
    const std::size_t count = nearest.find(near[a], found);
    for (std::size_t k = 0; k < count; ++k) {
      const auto b = static_cast<std::size_t>(found[k].index);
      if (b <= a) continue;
      const double squared = (apart[a] - apart[b]).squaredNorm();
      if (are_separated(std::sqrt(found[k].squared_distance), squared, spacing, config)) pairs.push_back({a, b});
    }
  }
  return pairs;
}

} // namespace

std::vector<std::size_t> find_separated_nodes(std::span<const Eigen::Vector3d> nodes, double spacing,
                                              std::span<const SE3> before, std::span<const SE3> now,
                                              std::span<const double> seen, const TopologyChangeConfig& config) {
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t n = 0; n < nodes.size(); ++n) positions.push_back(now[n] * nodes[n]);
  std::vector<std::size_t> separated;
  for (const auto& [a, b] : separated_pairs(nodes, positions, spacing, config)) {
    const double squared_before = (before[a] * nodes[a] - before[b] * nodes[b]).squaredNorm();
    const bool was_apart = are_separated((nodes[a] - nodes[b]).norm(), squared_before, spacing, config);
    if (was_apart && seen[a] > 0 && seen[b] > 0) separated.insert(separated.end(), {a, b});
  }
  const std::size_t pairs = separated.size() / 2;
  if (pairs < config.min_pairs) return {};
  if (pairs < config.min_ratio * separated_pairs(positions, nodes, spacing, config).size()) return {};
  return separated;
}

std::vector<SE3> separated_pose(std::span<const Eigen::Vector3d> nodes, std::span<const GraphEdge> edges,
                                std::span<const SE3> now, const TopologyChangeConfig& config) {
  std::vector<GraphEdge> intact_edges;
  for (const GraphEdge& edge : edges) {
    const auto a = static_cast<std::size_t>(edge.a);
    const auto b = static_cast<std::size_t>(edge.b);
    const double stretch = (now[a] * nodes[a] - now[b] * nodes[b]).norm() / (nodes[a] - nodes[b]).norm();
    if (stretch < config.max_stretch) intact_edges.push_back(edge);
  }
  return arap_deform(nodes, intact_edges, now, config.target_weight);
}

} // namespace kinora::tracking
