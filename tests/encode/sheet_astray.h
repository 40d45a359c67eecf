// The bending sheet as a tracker may leave it: its nodes a little beside their true places.
#pragma once

#include <cmath>

#include "fields/scenes/bending_sheet.h"
#include "tracking/model/surface_graph.h"

namespace kinora::encode::testing {

inline constexpr double kSpacing = 0.06; ///< of the sheet's nodes

inline std::vector<tracking::GraphEdge> edges_of(const motion::DeformationGraph& graph) {
  std::vector<tracking::GraphEdge> edges;
  const auto& nodes = graph.nodes();
  for (int a = 0; a < static_cast<int>(nodes.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(nodes.size()); ++b) {
      const double distance = (nodes[static_cast<std::size_t>(a)] - nodes[static_cast<std::size_t>(b)]).norm();
      if (distance < 1.5 * kSpacing) edges.push_back({a, b});
    }
  }
  return edges;
}

/// Each frame beside the truth, another way every time: what all frames share would be the canonical space's own place.
inline motion::Motion astray(const motion::Motion& truth, double metres) {
  std::vector<motion::Motion::Deformation> deformations = truth.deformations();
  for (std::size_t f = 0; f < deformations.size(); ++f) {
    const double angle = 2.4 * static_cast<double>(f);
    const Eigen::Translation3d aside(metres * std::cos(angle), metres * std::sin(angle), 0);
    for (DualQuaternion& node : deformations[f].node_to_world) node = DualQuaternion::from(SE3(aside * node.to_se3()));
  }
  return motion::Motion::deforming(truth.graph(), std::move(deformations));
}

/// Root mean square distance of a frame's nodes from their true places, metres.
inline double error_of(const motion::Motion& motion, const motion::Motion& truth, std::size_t frame) {
  const auto& nodes = truth.graph()->nodes();
  double sum = 0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    sum += (motion.deformations()[frame].node_to_world[n].to_se3() * nodes[n] -
            truth.deformations()[frame].node_to_world[n].to_se3() * nodes[n])
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(nodes.size()));
}

} // namespace kinora::encode::testing
