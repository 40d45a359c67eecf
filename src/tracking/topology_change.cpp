#include "tracking/topology_change.h"

#include <array>
#include <cmath>

namespace kinora::tracking {
namespace {

constexpr double kNear = 2;          // in units of the spacing: nodes that move the same points
constexpr double kApart = 1;         // likewise: by so much farther away from each other, they no longer do
constexpr double kMostStretch = 1.3; // of an edge that holds
constexpr double kPull = 0.3;        // of a node towards where it is, against one edge: what is mistaken stands alone
constexpr std::size_t kMost = 32;    // neighbours of a node that are looked at
constexpr std::size_t kFewest = 3;   // pairs that part; fewer may be mistaken
constexpr std::size_t kTimes = 2;    // as many pairs part as come together, or else the other pose is no better

bool are_parted(double distance, double squared_distance_there, double spacing) {
  const double apart = distance + kApart * spacing;
  return squared_distance_there > apart * apart;
}

/// Pairs of nodes that are near each other in one pose and apart in another.
std::vector<std::array<std::size_t, 2>> parted_pairs(std::span<const Eigen::Vector3d> near,
                                                     std::span<const Eigen::Vector3d> apart, double spacing) {
  std::vector<std::array<std::size_t, 2>> pairs;
  const NearestPoints nearest(near, kNear * spacing);
  std::array<NearestPoints::Neighbour, kMost> found{};
  for (std::size_t a = 0; a < near.size(); ++a) {
    const std::size_t count = nearest.find(near[a], found);
    for (std::size_t k = 0; k < count; ++k) {
      const auto b = static_cast<std::size_t>(found[k].index);
      if (b <= a) continue;
      const double squared = (apart[a] - apart[b]).squaredNorm();
      if (are_parted(std::sqrt(found[k].squared_distance), squared, spacing)) pairs.push_back({a, b});
    }
  }
  return pairs;
}

} // namespace

std::vector<std::size_t> find_parted_nodes(std::span<const Eigen::Vector3d> nodes, double spacing,
                                           std::span<const SE3> before, std::span<const SE3> now,
                                           std::span<const double> seen) {
  std::vector<Eigen::Vector3d> places;
  for (std::size_t n = 0; n < nodes.size(); ++n) places.push_back(now[n] * nodes[n]);
  std::vector<std::size_t> parted;
  for (const auto& [a, b] : parted_pairs(nodes, places, spacing)) {
    const double squared_before = (before[a] * nodes[a] - before[b] * nodes[b]).squaredNorm();
    const bool was_apart = are_parted((nodes[a] - nodes[b]).norm(), squared_before, spacing);
    if (was_apart && seen[a] > 0 && seen[b] > 0) parted.insert(parted.end(), {a, b});
  }
  const std::size_t pairs = parted.size() / 2;
  if (pairs < kFewest || pairs < kTimes * parted_pairs(places, nodes, spacing).size()) return {};
  return parted;
}

std::vector<SE3> parted_pose(std::span<const Eigen::Vector3d> nodes, std::span<const GraphEdge> edges,
                             std::span<const SE3> now) {
  std::vector<GraphEdge> holding;
  for (const GraphEdge& edge : edges) {
    const auto a = static_cast<std::size_t>(edge.a);
    const auto b = static_cast<std::size_t>(edge.b);
    const double stretch = (now[a] * nodes[a] - now[b] * nodes[b]).norm() / (nodes[a] - nodes[b]).norm();
    if (stretch < kMostStretch) holding.push_back(edge);
  }
  return rigid_pose(nodes, holding, now, kPull);
}

} // namespace kinora::tracking
