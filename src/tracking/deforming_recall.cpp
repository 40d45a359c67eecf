// Where a layer may be that was lost and is seen again: bent and turned as it was in some frame before, wherever it is
// now. Bones tell that of people; this tells it of everything.
#include <algorithm>
#include <numeric>

#include "tracking/deforming_selection.h"
#include "tracking/deforming_tracker.h"
#include "tracking/layer_search.h"

namespace kinora::tracking {
namespace {

/// Some of the surface, evenly drawn.
struct ThinSurface {
  std::vector<SurfacePoint> points;
  std::vector<Influence> skin;
};

ThinSurface thinned(std::span<const SurfacePoint> surface, std::span<const Influence> skin, std::size_t count) {
  ThinSurface thin;
  const std::size_t stride = surface.size() / std::max<std::size_t>(1, count) + 1;
  for (std::size_t i = 0; i < surface.size(); i += stride) {
    if (skin[i].count == 0) continue;
    thin.points.push_back(surface[i]);
    thin.skin.push_back(skin[i]);
  }
  return thin;
}

// Of what faces the camera; of everything if nothing does.
Eigen::Vector3d centre_of(const ThinSurface& surface, const NodeStates& states) {
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
  Eigen::Vector3d all = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const BlendedMotion motion = blend_motion(states, surface.skin[i]);
    const Eigen::Vector3d place = motion.apply(surface.points[i].position.cast<double>());
    all += place;
    if (motion.rotate(surface.points[i].normal.cast<double>()).dot(place) > 0) continue;
    facing += place;
    ++count;
  }
  if (count > 0) return facing / static_cast<double>(count);
  return all / static_cast<double>(std::max<std::size_t>(1, surface.points.size()));
}

} // namespace

std::vector<NodeStates> DeformingTracker::recalled(const ObjectView& view) const {
  const ThinSurface surface = thinned(surface_.points(), surface_.skin(), config_.relocalisation.ranked_points);
  std::vector<NodeStates> poses;
  std::vector<double> costs;
  for (const PoseLibrary::Entry& entry : library_.entries()) {
    NodeStates states = states_in(entry.world_to_camera, records_[entry.frame].nodes);
    states = moved(states, SE3(Eigen::Translation3d(view.centroid - centre_of(surface, states))));
    const DeformingSelection facing =
        select_facing(surface.points, surface.skin, view, states, config_.relocalisation.ranked_points);
    costs.push_back(contradiction({nodes_, edges(), facing.points}, facing.textures, view, states));
    poses.push_back(std::move(states));
  }
  std::vector<std::size_t> order(poses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return costs[a] < costs[b]; });
  if (order.size() > config_.relocalisation.aligned_poses) order.resize(config_.relocalisation.aligned_poses);
  std::vector<NodeStates> best;
  best.reserve(order.size());
  for (const std::size_t i : order) best.push_back(std::move(poses[i]));
  return best;
}

DeformingAlignment DeformingTracker::align_recalled(const ObjectView& view, std::span<const NodePull> binding,
                                                    DeformingAlignment best) const {
  const std::vector<GraphEdge> holding = holding_edges(binding);
  double most = shown_share(view, best.nodes);
  for (const NodeStates& pose : recalled(view)) {
    const DeformingSelection facing = select_facing(surface_.points(), surface_.skin(), view, pose, config_.max_points);
    const LayerModel model{nodes_, holding, facing.points};
    DeformingAlignment aligned =
        align_from_afar(model, facing, view, search_layer(model, facing.textures, view, pose).states, binding);
    const double shown = shown_share(view, aligned.nodes);
    if (!(shown > most)) continue;
    most = shown;
    best = std::move(aligned);
  }
  return best;
}

} // namespace kinora::tracking
