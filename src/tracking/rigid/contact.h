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

struct ContactConfig {
  double reach = 0.06;          ///< metres from the object's surface to what holds it: the back of a hand
  bool assumes_contact = false; ///< what is that near holds the object until the view says otherwise
  double min_motion = 0.02;     ///< metres that an object must have carried a place before that tells anything
  double max_slip = 0.3;        ///< of that motion, by which what is held may have slipped in the meantime
  double min_visible = 0.5;     ///< share of a place that the view shows: below, it teaches nothing
  double update_rate = 0.1;     ///< share of what one frame says: motion is that of the last ten frames or so
};

/// Places by number, in the world, metres. Not thread-safe.
class ContactTracker {
public:
  explicit ContactTracker(const ContactConfig& config = {}) : config_(config) {}

  /// Where all places are in a frame, and how much of each the view shows (in [0, 1]); what it does not show teaches
  /// nothing. Places may be added at the end from frame to frame.
  void update(std::span<const NearbyObject> objects, std::span<const Eigen::Vector3d> positions,
              std::span<const double> seen);

  /// Where the objects of a frame would have a place; nothing if it goes along with none of them.
  std::optional<Eigen::Vector3d> position_of(std::size_t point, std::span<const NearbyObject> objects) const;

  /// Whether a place goes along with the object of this label.
  bool is_in_contact(std::size_t point, int label) const;

private:
  /// Where a place was in the last frames that showed it, in the mean.
  struct MeanPosition {
    Eigen::Vector3d in_object, in_world;
    bool in_contact = false;
  };
  void classify(const NearbyObject& object, const Eigen::Vector3d& in_object, const Eigen::Vector3d& in_world,
                MeanPosition& mean) const;

  ContactConfig config_;
  std::map<int, std::vector<std::optional<MeanPosition>>> means_; ///< by the object's label
};

} // namespace kinora::tracking
