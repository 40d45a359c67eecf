// Which bones carry the nodes of a deformation graph, and where these bones would have each node: what the graph goes
// by where the camera sees nothing of it.
// Sources: Jiang et al., "Instant-NVR", CVPR 2023, eq. 2 (binding); Yu et al., "BodyFusion", ICCV 2017 (skeleton and
// graph, each bound to the other).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tracking/body/bone_attachment.h"
#include "tracking/body/limb_search.h"
#include "tracking/solver/deforming_problem.h"

namespace kinora::tracking {

/// Nodes by their number in the graph, each a place and a turn in the world, metres. Not thread-safe.
class BoneSkinning {
public:
  /// Binds the nodes that are not yet known (`nodes` has all, known or not) to the bones of the body's surface that is
  /// nearest to them. A node too far from the body is bound to nothing, and goes with the pelvis where it must go.
  /// So are known ones bound anew that the view shows (`seen`, for each known node, in [0, 1]) clearly nearer to other
  /// bones: the body was wrong when they were bound.
  void bind(const PosedBody& body, std::span<const SE3> nodes, std::span<const double> seen);

  /// Where a node lies beside its bones, anew: the more of it the view shows (`seen`, for each node, in [0, 1]), the
  /// nearer it comes to where `nodes` are.
  void update_offsets(const Bones& bones, std::span<const SE3> nodes, std::span<const double> seen);

  /// Another canonical pose of the nodes: in it each has turned by `before`, one for each node, already.
  void apply_inverse_rotation(std::span<const Eigen::Quaterniond> before);

  /// Where the bones have the node; nothing if it is not bound.
  std::optional<Eigen::Vector3d> position_of(std::size_t node, const Bones& bones) const;
  /// The same for all nodes as pulls for the solver, in the space that `from_world` leads to; `sigma` in metres. A limb
  /// that is lost pulls nothing.
  std::vector<NodeTarget> targets(const Bones& bones, const std::array<LimbHealth, kLimbs>& limbs,
                                  const SE3& from_world, double sigma) const;

  /// Whether two nodes do not hold each other however near they are: one is of an arm, the other of anything else, but
  /// for upper arms and the trunk. (Legs may be in one skirt.)
  bool are_disconnected(std::size_t a, std::size_t b) const;

  /// The bone that carries the node; nothing if it is not bound.
  std::optional<Joint> bone_of(std::size_t node) const;
  /// The limb that carries the node; nothing for trunk and head, or if it is not bound.
  std::optional<Limb> limb_of(std::size_t node) const;

  /// Where the bones would have every node, and how turned; a node that is bound to nothing goes with the pelvis.
  std::vector<SE3> node_transforms(const Bones& bones) const;

private:
  struct BoundNode {
    std::optional<BoneAttachment> attachment;
    SE3 in_bone;                    ///< in the space of the bone (or of the pelvis)
    Eigen::Vector3d in_second_bone; ///< its place in the space of the second bone
  };
  static Joint anchor_bone(const BoundNode& node_binding);
  static BoundNode bind_node(const PosedBody& body, const std::optional<BoneAttachment>& attachment, const SE3& node);

  std::vector<BoundNode> nodes_;
};

} // namespace kinora::tracking
