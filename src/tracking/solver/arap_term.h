// How much the neighbours in a deformation graph disagree, in single precision. Vectorised with Highway and chosen at
// run time for the processor; tests/tracking/solver/arap_term_test.cpp keeps it equal to a plain loop.
// Source: Sorkine and Alexa, "As-Rigid-As-Possible Surface Modeling", SGP 2007.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "motion/skinning/layer_pose.h"
#include "tracking/model/surface_graph.h"

namespace kinora::tracking {

/// An edge and the way along it in canonical space, metres; in rows of four numbers.
struct ArapEdge {
  std::array<float, 3> along; ///< from a to b
  float unused = 0;
  std::int32_t a, b;
};
std::vector<ArapEdge> rows_of(std::span<const GraphEdge> edges, std::span<const Eigen::Vector3d> nodes);

/// Where one node would have its neighbour, less where it is, metres; and Huber's weight of that over its variance.
struct ArapResidual {
  Eigen::Vector3f value;
  float weight;
};
/// As a has b, and as b has a.
using ArapResiduals = std::array<ArapResidual, 2>;

/// Half the sum of squares of all residuals in units of `sigma`, growing linearly beyond `huber` of them. `residuals`:
/// one item for each edge, or none wanted. Serial.
double arap_energy(std::span<const ArapEdge> edges, const motion::NodeRows& nodes, double sigma, double huber,
                   std::span<ArapResiduals> residuals = {});

} // namespace kinora::tracking
