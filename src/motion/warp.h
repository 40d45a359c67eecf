// Where canonical points of a layer are at one instant, and back.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/dual_quaternion.h"
#include "core/se3.h"
#include "motion/skinning/deformation_graph.h"

namespace kinora::motion {

/// One rigid transform, or a deformation graph with a transform per node, blended as dual quaternions. Immutable,
/// cheap to copy, thread-safe.
class Warp {
public:
  explicit Warp(const SE3& canonical_to_world) : rigid_(canonical_to_world) {}
  /// `node_to_world[i]` carries canonical points near node i into the world; one for each node of the graph.
  /// Throws Error(kFailure) if their number differs.
  Warp(std::shared_ptr<const DeformationGraph> graph, std::vector<DualQuaternion> node_to_world);

  bool is_rigid() const { return live_ == nullptr; }
  /// The transform of a rigid warp; of a deforming one the identity.
  const SE3& rigid() const { return rigid_; }

  /// The blended transform at a canonical point; nothing if no node is near enough: space there is empty.
  std::optional<SE3> at(const Eigen::Vector3d& canonical) const;
  /// The same where the nodes that move the point are known (at least one); only if not rigid.
  SE3 at(const Influence& influence) const;
  std::optional<Eigen::Vector3d> to_world(const Eigen::Vector3d& canonical) const;
  /// The canonical point that to_world() carries to `world`, to a tenth of a millimetre, or nothing if none is found
  /// near the nodes that are nearest to `world` now. Where the surface touches itself there may be several: the one
  /// whose node is nearest wins.
  std::optional<Eigen::Vector3d> to_canonical(const Eigen::Vector3d& world) const;

  const DeformationGraph* graph() const { return live_ ? live_->graph.get() : nullptr; }
  /// Positions of the nodes in the world; empty if rigid.
  const std::vector<Eigen::Vector3d>& node_positions() const;
  /// What the warp was made from; empty if rigid.
  const std::vector<DualQuaternion>& node_to_world() const;
  /// Fills `found` with the nodes that are nearest to a world point, as NearestPoints::find; 0 if rigid.
  std::size_t nearest_nodes(const Eigen::Vector3d& world, std::span<NearestPoints::Neighbour> found) const;

private:
  struct Live {
    std::shared_ptr<const DeformationGraph> graph;
    std::vector<DualQuaternion> node_to_world;
    std::vector<SE3> world_to_node; // inverses of the same transforms
    NearestPoints nearest;          // node positions in the world
  };

  SE3 rigid_ = SE3::Identity();
  std::shared_ptr<const Live> live_;
};

} // namespace kinora::motion
