#include "tracking/deforming/relocalisation.h"

#include <algorithm>
#include <numeric>

namespace kinora::tracking {
namespace {

/// Some of the surface, evenly drawn.
struct ThinSurface {
  std::vector<SurfacePoint> points;
  std::vector<motion::Influence> skin;
};

ThinSurface thinned(std::span<const SurfacePoint> surface, std::span<const motion::Influence> skin, std::size_t count) {
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
Eigen::Vector3d centre_of(const ThinSurface& surface, const motion::NodeStates& states) {
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
  Eigen::Vector3d all = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const motion::BlendedMotion motion = motion::blend_motion(states, surface.skin[i]);
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

void Relocalisation::remember(std::size_t frame, const SE3& origin_to_camera, const NodeTrajectory& trajectory) {
  library_.add(frame, origin_to_camera, trajectory.at(frame).nodes);
}

void Relocalisation::repose(const NodeTrajectory& trajectory) {
  PoseLibrary library;
  for (const PoseLibrary::Entry& entry : library_.entries()) {
    library.add(entry.frame, entry.world_to_camera, trajectory.at(entry.frame).nodes);
  }
  library_ = std::move(library);
}

DeformingAlignment Relocalisation::search(const ModelInView& now, const DeformingSelection& selection,
                                          const motion::NodeStates& prior, std::span<const SE3> placed,
                                          DeformingAlignment best) {
  DeformingAlignment elsewhere = now.align_from_anywhere(selection, prior);
  if (now.contradiction(selection, elsewhere.nodes) < now.contradiction(selection, best.nodes)) {
    best = std::move(elsewhere);
  }
  if (placed.empty()) return best;
  const motion::NodeStates start = now.states(placed);
  DeformingAlignment with_bones = now.align_from_afar(now.facing(start), start);
  if (now.shown_share(with_bones.nodes) > now.shown_share(best.nodes)) best = std::move(with_bones);
  return best;
}

// What is remembered, brought to the middle of what is measured: the few that the view contradicts least.
std::vector<motion::NodeStates> Relocalisation::candidates(const ModelInView& now,
                                                           const NodeTrajectory& trajectory) const {
  const ThinSurface surface = thinned(now.model().surface(), now.model().skin(), config_.ranked_points);
  std::vector<motion::NodeStates> poses;
  std::vector<double> costs;
  for (const PoseLibrary::Entry& entry : library_.entries()) {
    motion::NodeStates states = now.model().states(entry.world_to_camera, trajectory.at(entry.frame).nodes);
    states = moved(states, SE3(Eigen::Translation3d(now.view().centroid - centre_of(surface, states))));
    const DeformingSelection facing =
        select_facing(surface.points, surface.skin, now.view(), states, config_.ranked_points);
    costs.push_back(now.contradiction(facing, states));
    poses.push_back(std::move(states));
  }
  std::vector<std::size_t> order(poses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return costs[a] < costs[b]; });
  if (order.size() > config_.aligned_poses) order.resize(config_.aligned_poses);
  std::vector<motion::NodeStates> best;
  best.reserve(order.size());
  for (const std::size_t i : order) best.push_back(std::move(poses[i]));
  return best;
}

DeformingAlignment Relocalisation::recall(const ModelInView& now, const NodeTrajectory& trajectory,
                                          DeformingAlignment best) const {
  double most = now.shown_share(best.nodes);
  for (const motion::NodeStates& pose : candidates(now, trajectory)) {
    DeformingAlignment aligned = now.align_from_anywhere(now.facing(pose), pose);
    const double shown = now.shown_share(aligned.nodes);
    if (!(shown > most)) continue;
    most = shown;
    best = std::move(aligned);
  }
  return best;
}

} // namespace kinora::tracking
