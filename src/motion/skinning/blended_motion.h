// A point of a layer that several nodes move together, and how it moves when they do: exact derivatives of
// dual-quaternion blending.
// Source: Kavan et al., ACM TOG 27(4), 2008 (blending); Kavan et al., "Skinning with dual quaternions", I3D 2007.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/dual_quaternion.h"
#include "motion/skinning/deformation_graph.h"

namespace kinora::motion {

/// Where the nodes of a graph are: transforms from canonical space, and the nodes' positions there.
/// A step of a node is a twist about its own position: translation in metres, rotation in radians.
struct NodeStates {
  std::vector<DualQuaternion> transforms;
  std::vector<Eigen::Vector3d> positions;

  std::size_t size() const { return transforms.size(); }
  void push_back(const DualQuaternion& transform, const Eigen::Vector3d& canonical_node);
  void push_back(const SE3& transform, const Eigen::Vector3d& canonical_node);
};

/// States after a step of every node.
NodeStates stepped(const NodeStates& states, std::span<const Twist> step);

/// The states moved as one rigid body: `motion` after each transform.
NodeStates moved(const NodeStates& states, const SE3& motion);

/// The transform at a point, normalised, with what its derivative needs.
struct BlendedMotion {
  DualQuaternion transform;
  std::array<double, Influence::kMax> signs{}; ///< ±1: the hemisphere of the heaviest node
  double real_norm = 1;                        ///< of the sum before normalisation …
  double dual_norm = 0;                        ///< … a dual number

  Eigen::Vector3d apply(const Eigen::Vector3d& point) const;
  Eigen::Vector3d rotate(const Eigen::Vector3d& vector) const;
};

/// `influence.count` must be at least 1. The plain way, in double precision: skinning_simd.h does the same in lanes.
BlendedMotion blend_motion(std::span<const DualQuaternion> transforms, const Influence& influence);
BlendedMotion blend_motion(const NodeStates& states, const Influence& influence);

/// What a step of one node does to the transform at a point that it moves.
class NodeJacobian {
public:
  /// Of the influence's node `slot`; `blended`: of the same states and influence. Refers to none of them afterwards.
  NodeJacobian(const NodeStates& states, const Influence& influence, const BlendedMotion& blended, std::size_t slot);

  /// Derivative of g·t + m·ω by the node's step, where (t, ω) is the twist about the origin by which the transform at
  /// the point changes.
  Twist pullback(const Eigen::Vector3d& g, const Eigen::Vector3d& m) const;

private:
  Eigen::Quaterniond real_; ///< twists (t, ω) of the node make the pure part of (ω + εt) · (real + ε dual) at the point
  Eigen::Quaterniond dual_;
  Eigen::Vector3d position_; ///< of the node
};

} // namespace kinora::motion
