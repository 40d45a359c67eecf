// A pose of a deformation graph near to a given one, without what is not the motion of rigid parts: nodes that were
// mistaken, or dragged along.
// Source: Sorkine and Alexa, "As-Rigid-As-Possible Surface Modeling", SGP 2007.
#pragma once

#include <span>
#include <vector>

#include "core/se3.h"
#include "tracking/model/surface_graph.h"

namespace kinora::tracking {

/// For each node a transform that carries its place in `nodes` to a new one. Neighbours along `edges` keep their
/// places relative to each other as far as turning node by node allows, and all nodes stay near to `targets`:
/// `target_weight` is what a squared metre from there weighs against one between neighbours; > 0. Places in metres, in
/// any one space; `targets`: one for each node, with the turn to begin with. Thread-safe.
std::vector<SE3> arap_deform(std::span<const Eigen::Vector3d> nodes, std::span<const GraphEdge> edges,
                             std::span<const SE3> targets, double target_weight);

} // namespace kinora::tracking
