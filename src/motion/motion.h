// Where a layer's canonical points are at every frame of a clip.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "core/se3.h"
#include "motion/warp.h"

namespace kinora::motion {

enum class MotionKind { kStill, kRigid, kDeforming };
enum class Health { kTracked, kHeld, kLost };

std::string_view name_of(MotionKind kind);
std::string_view name_of(Health health);

/// Canonical space of a layer = world space at the layer's first frame, or, of one that deforms, at another. Plain
/// data; thread-safe to read.
class Motion {
public:
  /// One pose of a rigid layer.
  struct Pose {
    SE3 canonical_to_world = SE3::Identity();
    Health health = Health::kTracked;
  };
  /// One frame of a deforming layer: a transform for each node of the graph.
  struct Deformation {
    std::vector<DualQuaternion> node_to_world;
    Health health = Health::kTracked;
  };

  static Motion still() { return Motion(MotionKind::kStill); }
  /// One pose for each frame of the clip, in order; at least one.
  static Motion rigid(std::vector<Pose> poses);
  /// One deformation for each frame of the clip, in order; at least one. Throws Error(kFailure) if a frame's number of
  /// transforms is not that of the graph's nodes.
  static Motion deforming(std::shared_ptr<const DeformationGraph> graph, std::vector<Deformation> deformations);

  MotionKind kind() const { return kind_; }
  /// Empty unless the layer is rigid.
  const std::vector<Pose>& poses() const { return poses_; }
  /// Null and empty unless the layer deforms.
  const std::shared_ptr<const DeformationGraph>& graph() const { return graph_; }
  const std::vector<Deformation>& deformations() const { return deformations_; }

  /// At a whole or fractional frame; in between, along the screw from one pose to the next (of each node); clamped at
  /// both ends.
  Warp warp(double frame) const;
  /// The same of a still or rigid layer; throws Error(kFailure) for a deforming one, which has no single transform.
  SE3 canonical_to_world(double frame) const;
  Health health(std::size_t frame) const;

private:
  explicit Motion(MotionKind kind) : kind_(kind) {}

  MotionKind kind_;
  std::vector<Pose> poses_;
  std::shared_ptr<const DeformationGraph> graph_;
  std::vector<Deformation> deformations_;
};

} // namespace kinora::motion
