#include "tracking/deforming/model_in_view.h"

#include <utility>

#include "tracking/deforming/pose_search.h"

namespace kinora::tracking {

ModelInView::ModelInView(const CanonicalModel& model, const LayerView& view, const SE3& camera_to_world,
                         NodeConstraints constraints, const ModelInViewConfig& config)
    : model_(model), view_(view), origin_to_camera_(model.origin_to_camera(camera_to_world)),
      constraints_(std::move(constraints)), config_(config) {}

std::vector<SE3> ModelInView::transforms(const motion::NodeStates& states) const {
  const SE3 camera_to_origin = origin_to_camera_.inverse();
  std::vector<SE3> transforms;
  transforms.reserve(states.size());
  for (const DualQuaternion& node : states.transforms) {
    transforms.push_back(renormalized(camera_to_origin * node.to_se3()));
  }
  return transforms;
}

DeformingSelection ModelInView::facing(const motion::NodeStates& states,
                                       const std::function<bool(const motion::Influence&)>& takes_part) const {
  return select_facing(model_.surface(), model_.skin(), view_, states, config_.max_points, takes_part);
}

double ModelInView::facing_inlier_share(const motion::NodeStates& states,
                                        const std::function<bool(const motion::Influence&)>& takes_part) const {
  const DeformingSelection selection = facing(states, takes_part);
  if (selection.points.empty()) return 0;
  return static_cast<double>(quality(selection, states).inliers) / static_cast<double>(selection.points.size());
}

DeformingQuality ModelInView::quality(const DeformingSelection& selection, const motion::NodeStates& states) const {
  return evaluate_deformation(layer(selection), selection.textures, view_, states);
}

double ModelInView::alignment_cost(const DeformingSelection& selection, const motion::NodeStates& states) const {
  return tracking::alignment_cost(layer(selection), selection.textures, view_, states);
}

DeformingAlignment ModelInView::align(const DeformingSelection& selection, const motion::NodeStates& start,
                                      const motion::NodeStates& prior) const {
  return align_deforming(layer(selection), selection.textures, view_, start, prior, model_.spacing(), config_.solver,
                         constraints_.targets);
}

DeformingAlignment ModelInView::align_repeatedly(const DeformingSelection& selection, motion::NodeStates start) const {
  DeformingAlignment alignment;
  alignment.nodes = std::move(start);
  for (int pass = 0; pass < config_.passes; ++pass) alignment = align(selection, alignment.nodes, alignment.nodes);
  return alignment;
}

DeformingAlignment ModelInView::align_with_search(const DeformingSelection& selection,
                                                  const motion::NodeStates& start) const {
  return align_repeatedly(selection, search_pose(layer(selection), selection.textures, view_, start).states);
}

} // namespace kinora::tracking
