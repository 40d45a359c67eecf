// Which places of a layer that bends go along with a rigid object: a hand that holds a box goes where the box goes,
// also while the box hides it. Source: Jiang et al., "Instant-NVR", CVPR 2023, eq. 2 (interaction), of which this is
// the contact that persists.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/se3.h"
#include "tracking/rigid/rigid_tracker.h"

namespace kinora::tracking {

/// A rigid object as it is in one frame, in which it was tracked.
struct NearbyObject {
  int label;
  SE3 canonical_to_world;
  std::span<const SurfacePoint> surface; ///< of its model, relative to `origin`
  Eigen::Vector3d origin;                ///< canonical
};

/// Nothing unless the tracker has found its object in its last frame. The tracker must outlive what refers to it.
std::optional<NearbyObject> nearby_object(const RigidTracker& tracker);

struct InteractionConfig {
  double reach = 0.06;        ///< metres from the object's surface to what holds it: the back of a hand
  bool presumes = false;      ///< what is that near holds the object until the view says otherwise
  double least_motion = 0.02; ///< metres that an object must have carried a place before that tells anything
  double most_slip = 0.3;     ///< of that motion, by which what is held may have slipped in the meantime
  double min_seen = 0.5;      ///< share of a place that the view shows: below, it teaches nothing
  double renewed = 0.1;       ///< share of what one frame says: motion is that of the last ten frames or so
};

/// Places by number, in the world, metres. Not thread-safe.
class Interaction {
public:
  explicit Interaction(const InteractionConfig& config = {}) : config_(config) {}

  /// Where all places are in a frame, and how much of each the view shows (in [0, 1]); what it does not show teaches
  /// nothing. Places may be added at the end from frame to frame.
  void learn(std::span<const NearbyObject> objects, std::span<const Eigen::Vector3d> places,
             std::span<const double> seen);

  /// Where the objects of a frame would have a place; nothing if it goes along with none of them.
  std::optional<Eigen::Vector3d> place_of(std::size_t number, std::span<const NearbyObject> objects) const;

  /// Whether a place goes along with the object of this label.
  bool holds(std::size_t number, int label) const;

private:
  /// Where a place was in the last frames that showed it, in the mean.
  struct Mean {
    Eigen::Vector3d in_object, in_world;
    bool is_held = false;
  };
  void decide(const NearbyObject& object, const Eigen::Vector3d& in_object, const Eigen::Vector3d& in_world,
              Mean& mean) const;

  InteractionConfig config_;
  std::map<int, std::vector<std::optional<Mean>>> means_; ///< by the object's label
};

} // namespace kinora::tracking
