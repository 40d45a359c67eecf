// The skeleton of a layer that bends, if the layer is a person: followed beside the graph, bound to it, and kept only
// if it explains what is seen.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "motion/joint_paths.h"
#include "tracking/body/body_tracker.h"
#include "tracking/deforming/bone_skinning.h"

namespace kinora::tracking {

/// Whether a layer is a person.
enum class BodyVerdict {
  kUndecided, ///< too few frames
  kPerson,    ///< the body lies on what is measured, and is nowhere that the camera sees past
  kNobody     ///< it does not
};
std::string_view name_of(BodyVerdict verdict);

struct LayerBodyConfig {
  BodyTrackerConfig tracker;
  int deciding_frames = 10;     ///< in which the body is only looked at
  double min_explained = 0.75;  ///< of what is measured, in the mean over all frames so far
  double max_free_space = 0.15; ///< of the body that nothing hides, likewise
  double binding_sigma = 0.02;  ///< metres
};

/// Places are in the world, metres. Not thread-safe. Same views, same bits, for any number of threads.
class LayerBody {
public:
  explicit LayerBody(const LayerBodyConfig& config = {}) : config_(config), tracker_(config.tracker) {}

  /// The next frame, whether the layer is seen in it or not; time in seconds. A layer that has turned out to be nobody
  /// is not followed on. `objects`: those that the hands may hold, as they are in this frame.
  void track(const LayerView& view, const SE3& camera_to_world, double time,
             std::span<const NearbyObject> objects = {});

  /// Where the bones would have the graph's nodes in a frame (counted from 0), in the space that `from_world` leads to;
  /// none if there is no body to trust.
  std::vector<NodeTarget> targets(std::size_t frame, const SE3& from_world) const;
  /// Where the bones would have each node in a frame, as a place and a turn; none if there is no person in it.
  std::vector<SE3> node_transforms(std::size_t frame) const;
  /// The bone that carries a node; nothing if none does.
  std::optional<Joint> bone_of(std::size_t node) const { return binding_.bone_of(node); }
  /// The limb that carries a node; nothing for trunk and head.
  std::optional<Limb> limb_of(std::size_t node) const { return binding_.limb_of(node); }
  /// As BoneSkinning::are_disconnected.
  bool are_disconnected(std::size_t a, std::size_t b) const { return binding_.are_disconnected(a, b); }
  /// Whether the last frame shows the lower bones of a limb, and the body can be trusted.
  bool is_visible(Limb limb) const;
  /// Where the nodes are in the last frame, a place and a turn, and how much of each the view shows (both one for each
  /// node); nodes that were not there before are bound.
  void update(std::span<const SE3> nodes, std::span<const double> seen);
  /// As BoneSkinning::apply_inverse_rotation.
  void apply_inverse_rotation(std::span<const Eigen::Quaterniond> before) { binding_.apply_inverse_rotation(before); }

  BodyVerdict verdict() const;
  /// Of all frames so far, those before the first that shows the body as in that; nothing unless it is a person.
  std::optional<motion::JointPaths> joint_paths() const;
  double explained() const { return frames_ > 0 ? explained_ / frames_ : 0.0; }
  double free_space() const { return frames_ > 0 ? free_space_ / frames_ : 0.0; }
  double detected() const { return frames_ > 0 ? detected_ / frames_ : 0.0; } ///< joints that a detector has found

private:
  LayerBodyConfig config_;
  BodyTracker tracker_;
  BoneSkinning binding_;
  BodyTrackingResult last_;
  struct Record {
    Bones bones;
    std::array<LimbHealth, kLimbs> limbs;
    bool trusted; ///< it goes on from the frame before, and lies on what is seen
  };
  std::vector<std::optional<Record>> records_;           ///< of all frames; nothing before the first that shows a body
  int frames_ = 0;                                       ///< that count
  double explained_ = 0, free_space_ = 0, detected_ = 0; ///< sums
};

} // namespace kinora::tracking
