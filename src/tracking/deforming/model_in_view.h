// The canonical model of a deforming layer before one view: which of its points take part, how well a pose explains the
// view, and where alignment leads from one.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "tracking/deforming/canonical_model.h"
#include "tracking/deforming/deforming_alignment.h"
#include "tracking/deforming/deforming_point_selection.h"
#include "tracking/deforming/layer_binding.h"

namespace kinora::tracking {

struct ModelInViewConfig {
  std::size_t max_points = 6000; ///< model points used for alignment
  DeformingAlignmentConfig solver;
  int passes = 3; ///< of alignment from afar
};

/// `NodeStates` are canonical to camera. Refers to model, view and configuration, which must outlive it. Thread-safe.
class ModelInView {
public:
  ModelInView(const CanonicalModel& model, const LayerView& view, const SE3& camera_to_world,
              NodeConstraints constraints, const ModelInViewConfig& config);

  const CanonicalModel& model() const { return model_; }
  const LayerView& view() const { return view_; }
  const SE3& origin_to_camera() const { return origin_to_camera_; }

  /// `transforms`: of each node, canonical to world, both relative to the origin; and back.
  motion::NodeStates states(std::span<const SE3> transforms) const {
    return model_.states(origin_to_camera_, transforms);
  }
  std::vector<SE3> transforms(const motion::NodeStates& states) const;

  /// As select_facing, of the model's surface.
  DeformingSelection facing(const motion::NodeStates& states,
                            const std::function<bool(const motion::Influence&)>& takes_part = {}) const;

  /// The share of the surface that would face the camera that the view shows where it is.
  double facing_inlier_share(const motion::NodeStates& states,
                             const std::function<bool(const motion::Influence&)>& takes_part = {}) const;
  DeformingQuality quality(const DeformingSelection& selection, const motion::NodeStates& states) const;
  /// As tracking::contradiction.
  double alignment_cost(const DeformingSelection& selection, const motion::NodeStates& states) const;

  DeformingAlignment align(const DeformingSelection& selection, const motion::NodeStates& start,
                           const motion::NodeStates& prior) const;
  /// Without a frame just before, from which there is farther to go.
  DeformingAlignment align_repeatedly(const DeformingSelection& selection, motion::NodeStates start) const;
  /// The same from the place in the whole view to which search_pose() leads.
  DeformingAlignment align_with_search(const DeformingSelection& selection, const motion::NodeStates& start) const;

private:
  LayerModel layer(const DeformingSelection& selection) const {
    return {model_.nodes(), constraints_.edges, selection.points};
  }

  const CanonicalModel& model_;
  const LayerView& view_;
  SE3 origin_to_camera_;
  NodeConstraints constraints_;
  const ModelInViewConfig& config_;
};

} // namespace kinora::tracking
