// What the nodes of a deforming layer go by beside the view: the bones of a body, if the layer is a person, and the
// objects that it holds.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "tracking/deforming/canonical_model.h"
#include "tracking/deforming/layer_body.h"
#include "tracking/deforming/node_trajectory.h"
#include "tracking/rigid/contact.h"

namespace kinora::tracking {

struct LayerBindingConfig {
  bool use_body = true; ///< false: no skeleton is looked for
  LayerBodyConfig body;
  ContactConfig contact;
  double contact_sigma = 0.01; ///< metres, of a node beside the object that it holds
};

/// What holds the nodes in one frame.
struct NodeConstraints {
  std::vector<NodeTarget> targets; ///< one for each node; a scale of zero where nothing pulls
  std::vector<GraphEdge> edges;    ///< but those between surfaces that only happen to be side by side
};

/// Frames are counted from the capture's first one. Not thread-safe. Same calls, same bits, for any number of threads.
class LayerBinding {
public:
  explicit LayerBinding(const LayerBindingConfig& config = {})
      : config_(config), body_(config.body), contacts_(config.contact) {}

  /// The next frame, whether the layer is seen in it or not. `objects`: those that it may hold, as they are in this
  /// frame.
  void track(const LayerView& view, const SE3& camera_to_world, double time, std::span<const NearbyObject> objects);

  /// In a frame so far. `objects`: those of that frame; without, bones alone pull.
  NodeConstraints constraints(const CanonicalModel& model, std::size_t frame, const SE3& world_to_camera,
                              std::span<const NearbyObject> objects = {}) const;
  /// The nodes (relative to the origin) as the bones would have them in a frame; none if there are no bones.
  std::vector<SE3> bone_driven_nodes(const CanonicalModel& model, std::size_t frame) const;

  /// What the last frame, in which the layer was found, tells: where the nodes are, and how much of each it shows; of
  /// those that it has brought, nothing.
  void update(const CanonicalModel& model, const NodeTrajectory& trajectory, std::span<const double> seen,
              std::span<const NearbyObject> objects);
  /// As NodeTrajectory::repose.
  void set_canonical_pose(std::span<const SE3> pose);

  /// How the layer has moved an object that it holds, in the world, since the last frame that found both: the rigid
  /// motion of the nodes that hold it and are seen, or else of those on a limb that is seen. Nothing if it holds none
  /// of this label, or none of these is seen.
  std::optional<SE3> contact_motion(int label, const CanonicalModel& model, const NodeTrajectory& trajectory) const;

  const LayerBody& body() const { return body_; }

private:
  LayerBindingConfig config_;
  LayerBody body_;
  ContactTracker contacts_;
  std::map<int, std::size_t> last_contact_; ///< by the object's label: the last frame in which both were found
  std::vector<double> seen_; ///< how much of each node the last frame shows; empty if the layer was not found
};

} // namespace kinora::tracking
