#include "tracking/deforming/relocalisation.h"

#include <algorithm>
#include <numeric>

namespace kinora::tracking {
namespace {

/// Some of the surface, evenly drawn.
struct DownsampledSurface {
  std::vector<SurfacePoint> points;
  std::vector<motion::Influence> skin;
};

DownsampledSurface downsampled(std::span<const SurfacePoint> surface, std::span<const motion::Influence> skin,
                               std::size_t count) {
  DownsampledSurface result;
  const std::size_t stride = surface.size() / std::max<std::size_t>(1, count) + 1;
  for (std::size_t i = 0; i < surface.size(); i += stride) {
    if (skin[i].count == 0) continue;
    result.points.push_back(surface[i]);
    result.skin.push_back(skin[i]);
  }
  return result;
}

// Of what faces the camera; of everything if nothing does.
Eigen::Vector3d centre_of(const DownsampledSurface& surface, const motion::NodeStates& states) {
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
  Eigen::Vector3d all = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const motion::BlendedMotion motion = motion::blend_motion(states, surface.skin[i]);
    const Eigen::Vector3d position = motion.apply(surface.points[i].position.cast<double>());
    all += position;
    if (motion.rotate(surface.points[i].normal.cast<double>()).dot(position) > 0) continue;
    facing += position;
    ++count;
  }
  if (count > 0) return facing / static_cast<double>(count);
  return all / static_cast<double>(std::max<std::size_t>(1, surface.points.size()));
}

} // namespace

void Relocalisation::add(std::size_t frame, const SE3& origin_to_camera, const NodeTrajectory& trajectory) {
  pose_database_.add(frame, origin_to_camera, trajectory.at(frame).nodes);
}

void Relocalisation::set_canonical_pose(const NodeTrajectory& trajectory) {
  PoseDatabase database;
  for (const PoseDatabase::Entry& entry : pose_database_.entries()) {
    database.add(entry.frame, entry.world_to_camera, trajectory.at(entry.frame).nodes);
  }
  pose_database_ = std::move(database);
}

DeformingAlignment Relocalisation::search(const ModelInView& now, const DeformingSelection& selection,
                                          const motion::NodeStates& prior, std::span<const SE3> node_transforms,
                                          DeformingAlignment best) {
  DeformingAlignment elsewhere = now.align_with_search(selection, prior);
  if (now.alignment_cost(selection, elsewhere.nodes) < now.alignment_cost(selection, best.nodes)) {
    best = std::move(elsewhere);
  }
  if (node_transforms.empty()) return best;
  const motion::NodeStates start = now.states(node_transforms);
  DeformingAlignment with_bones = now.align_repeatedly(now.facing(start), start);
  if (now.facing_inlier_share(with_bones.nodes) > now.facing_inlier_share(best.nodes)) best = std::move(with_bones);
  return best;
}

// What is remembered, brought to the middle of what is measured: the few that the view contradicts least.
std::vector<motion::NodeStates> Relocalisation::candidates(const ModelInView& now,
                                                           const NodeTrajectory& trajectory) const {
  const DownsampledSurface surface = downsampled(now.model().surface(), now.model().skin(), config_.max_ranked_points);
  std::vector<motion::NodeStates> poses;
  std::vector<double> costs;
  for (const PoseDatabase::Entry& entry : pose_database_.entries()) {
    motion::NodeStates states = now.model().states(entry.world_to_camera, trajectory.at(entry.frame).nodes);
    states = moved(states, SE3(Eigen::Translation3d(now.view().centroid - centre_of(surface, states))));
    const DeformingSelection facing =
        select_facing(surface.points, surface.skin, now.view(), states, config_.max_ranked_points);
    costs.push_back(now.alignment_cost(facing, states));
    poses.push_back(std::move(states));
  }
  std::vector<std::size_t> order(poses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return costs[a] < costs[b]; });
  if (order.size() > config_.max_aligned_poses) order.resize(config_.max_aligned_poses);
  std::vector<motion::NodeStates> best;
  best.reserve(order.size());
  for (const std::size_t i : order) best.push_back(std::move(poses[i]));
  return best;
}

DeformingAlignment Relocalisation::relocalise(const ModelInView& now, const NodeTrajectory& trajectory,
                                              DeformingAlignment best) const {
  double best_share = now.facing_inlier_share(best.nodes);
  for (const motion::NodeStates& pose : candidates(now, trajectory)) {
    DeformingAlignment aligned = now.align_with_search(now.facing(pose), pose);
    const double shown = now.facing_inlier_share(aligned.nodes);
    if (!(shown > best_share)) continue;
    best_share = shown;
    best = std::move(aligned);
  }
  return best;
}

} // namespace kinora::tracking
