// Follows one layer that bends through a capture, fuses what it sees of it, and grows its deformation graph.
// Sources: Newcombe et al., "DynamicFusion", CVPR 2015; Innmann et al., "VolumeDeform", ECCV 2016; Jiang et al.,
// "Instant-NVR", CVPR 2023, eq. 1–2; the body, if there is one, is fitted before the graph (layer_body.h).
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "ingest/frame/frame.h"
#include "tracking/deforming/backward_smoothing.h"
#include "tracking/deforming/model_in_view.h"
#include "tracking/deforming/pose_prediction.h"
#include "tracking/deforming/relocalisation.h"
#include "tracking/deforming/topology_change.h"
#include "tracking/deforming/tracked_layer.h"
#include "tracking/lost/held_or_lost.h"
#include "tracking/view/frame_history.h"

namespace kinora::tracking {

/// When a layer is looked for elsewhere than where it is expected.
struct DeformingSearchConfig {
  double max_free_space_share = 0.25; ///< of the model: above, other places are tried as well
  double min_correlation = 0.4;       ///< of the texture: below, likewise
};

struct DeformingTrackerConfig {
  std::size_t first_pixels = 150; ///< pixels with clean depth that the layer's first frame must have
  std::size_t min_pixels = 60;    ///< fewer: the deformation is held
  double min_inlier_share = 0.5;  ///< of the points that fall on the layer; below, the deformation is not believed
  double max_free_space = 0.5;    ///< of the points in view, where the camera sees past them; above, likewise
  int held_frames = 30;           ///< unseen for longer: lost
  bool use_objects = true;        ///< false: nothing is held
  bool use_searches = true; ///< false: as predicted and aligned; limbs, texture and lost layers are not looked for
  CanonicalModelConfig model;
  LayerBindingConfig binding;
  ModelInViewConfig in_view;
  PosePredictionConfig prediction;
  DeformingSearchConfig search;
  RelocalisationConfig relocalisation;
  TopologyChangeConfig topology;
  BackwardSmoothingConfig backward;
};

/// One frame's answer.
struct DeformingTrackingResult {
  motion::Health health = motion::Health::kLost;
  std::size_t pixels = 0; ///< of the layer, with clean depth
  std::size_t nodes = 0;
  DeformingQuality quality;
};

/// Health: kTracked: the view supports the deformation; kHeld: too little is seen, the last one stays; kLost: it is
/// seen but not found, or unseen for long, or not yet seen at all. Only tracked frames are fused.
/// Not thread-safe. Same frames, same bits, for any number of threads.
class DeformingTracker {
public:
  explicit DeformingTracker(int label, const DeformingTrackerConfig& config = {})
      : label_(label), config_(config), binding_(config.binding) {}

  /// Frames in order of time. A frame without labels is the layer's as a whole. Throws Error(kFailure) if the frame's
  /// images differ in size. `objects`: those that the layer may hold, as they are in this frame.
  DeformingTrackingResult track(const ingest::Frame& frame, std::span<const NearbyObject> objects = {});

  /// As LayerBinding::contact_motion, as of the last frame.
  std::optional<SE3> contact_motion_of(int label) const;

  int label() const { return label_; }
  bool was_seen() const { return seen_.has_value(); }
  /// The motion over all frames so far, as in TrackedLayer. Throws Error(kFailure) before the layer was seen.
  motion::Motion motion() const;

  /// After the last frame: what was found late is followed back to where it was before (smooth_backward). Nothing if
  /// the layer was never seen.
  std::optional<TrackedLayer> finish() &&;

private:
  /// What there is once the layer has been seen.
  struct Seen {
    CanonicalModel model;
    NodeTrajectory trajectory;
    TrackedView last_found;
    HeldOrLost gap;
    Relocalisation relocalisation;
  };

  motion::Health begin(const ingest::Frame& frame, const LayerView& view);
  motion::Health follow(const ingest::Frame& frame, const LayerView& view, std::span<const NearbyObject> objects,
                        DeformingQuality& quality);
  DeformingAlignment align(const ModelInView& now, double time, DeformingQuality& quality) const;
  void accept(const ModelInView& now, double time, DeformingAlignment alignment, const DeformingQuality& quality,
              std::span<const NearbyObject> objects);
  motion::NodeStates part_surfaces(const ModelInView& now, std::span<const std::size_t> separated);
  bool is_healthy(const DeformingQuality& quality) const;
  bool is_doubtful(const DeformingQuality& quality) const;

  int label_;
  DeformingTrackerConfig config_;
  LayerBinding binding_;
  FrameHistory history_; ///< of all frames so far
  std::optional<Seen> seen_;
};

} // namespace kinora::tracking
