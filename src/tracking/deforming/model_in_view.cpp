#include "tracking/deforming/model_in_view.h"

#include <utility>

#include "tracking/deforming/layer_search.h"

namespace kinora::tracking {

ModelInView::ModelInView(const CanonicalModel& model, const ObjectView& view, const SE3& camera_to_world, NodeTies ties,
                         const ModelInViewConfig& config)
    : model_(model), view_(view), origin_to_camera_(model.origin_to_camera(camera_to_world)), ties_(std::move(ties)),
      config_(config) {}

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

double ModelInView::shown_share(const motion::NodeStates& states,
                                const std::function<bool(const motion::Influence&)>& takes_part) const {
  const DeformingSelection selection = facing(states, takes_part);
  if (selection.points.empty()) return 0;
  return static_cast<double>(quality(selection, states).inliers) / static_cast<double>(selection.points.size());
}

DeformingQuality ModelInView::quality(const DeformingSelection& selection, const motion::NodeStates& states) const {
  return judge_deformation(layer(selection), selection.textures, view_, states);
}

double ModelInView::contradiction(const DeformingSelection& selection, const motion::NodeStates& states) const {
  return tracking::contradiction(layer(selection), selection.textures, view_, states);
}

DeformingAlignment ModelInView::align(const DeformingSelection& selection, const motion::NodeStates& start,
                                      const motion::NodeStates& prior) const {
  return align_deforming(layer(selection), selection.textures, view_, start, prior, model_.spacing(), config_.solver,
                         ties_.pulls);
}

DeformingAlignment ModelInView::align_from_afar(const DeformingSelection& selection, motion::NodeStates start) const {
  DeformingAlignment alignment;
  alignment.nodes = std::move(start);
  for (int pass = 0; pass < config_.passes; ++pass) alignment = align(selection, alignment.nodes, alignment.nodes);
  return alignment;
}

DeformingAlignment ModelInView::align_from_anywhere(const DeformingSelection& selection,
                                                    const motion::NodeStates& start) const {
  return align_from_afar(selection, search_layer(layer(selection), selection.textures, view_, start).states);
}

} // namespace kinora::tracking
