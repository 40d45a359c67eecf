#include "tracking/deforming/deforming_tracker.h"

#include <utility>

#include "core/error.h"
#include "tracking/view/deforming_view.h"

namespace kinora::tracking {

DeformingTrackingResult DeformingTracker::track(const ingest::Frame& frame, std::span<const NearbyObject> objects) {
  if (!config_.use_objects) objects = {};
  LayerView view = view_layer(frame, label_);
  DeformingTrackingResult result;
  result.pixels = view.depth_pixels;
  binding_.track(view, frame.camera.camera_to_world, frame.time, objects);
  result.health = seen_ ? follow(frame, view, objects, result.quality) : begin(frame, view);
  history_.add(frame, view);
  if (!seen_) return result;
  result.nodes = seen_->model.nodes().size();
  if (result.health == motion::Health::kTracked) {
    seen_->last_found = {std::move(view), seen_->model.origin_to_camera(frame.camera.camera_to_world)};
  }
  return result;
}

motion::Health DeformingTracker::begin(const ingest::Frame& frame, const LayerView& view) {
  if (view.depth_pixels < config_.first_pixels) return motion::Health::kLost;
  auto model = CanonicalModel::from_view(view, frame.camera.camera_to_world, config_.model);
  if (!model) return motion::Health::kLost;
  NodeTrajectory trajectory(history_.count(), model->nodes().size(), frame.time);
  seen_.emplace(Seen{std::move(*model),
                     std::move(trajectory),
                     {},
                     HeldOrLost(config_.held_frames),
                     Relocalisation(config_.relocalisation)});
  const SE3 origin_to_camera = seen_->model.origin_to_camera(frame.camera.camera_to_world);
  seen_->relocalisation.add(history_.count(), origin_to_camera, seen_->trajectory);
  binding_.update(seen_->model, seen_->trajectory, {}, {});
  return motion::Health::kTracked;
}

motion::Health DeformingTracker::follow(const ingest::Frame& frame, const LayerView& view,
                                        std::span<const NearbyObject> objects, DeformingQuality& quality) {
  motion::Health health = motion::Health::kHeld;
  if (view.depth_pixels >= config_.min_pixels) {
    const SE3& camera_to_world = frame.camera.camera_to_world;
    NodeConstraints constraints =
        binding_.constraints(seen_->model, history_.count(), camera_to_world.inverse(), objects);
    const ModelInView now(seen_->model, view, camera_to_world, std::move(constraints), config_.in_view);
    DeformingAlignment alignment = align(now, frame.time, quality);
    health = is_healthy(quality) ? motion::Health::kTracked : motion::Health::kLost;
    if (health == motion::Health::kTracked) accept(now, frame.time, std::move(alignment), quality, objects);
  }
  health = seen_->gap.add(health);
  if (health != motion::Health::kTracked) seen_->trajectory.add_untracked(health, frame.time);
  return health;
}

// Where the nodes are: near to where they are expected, or, if that is not to be believed, elsewhere.
DeformingAlignment DeformingTracker::align(const ModelInView& now, double time, DeformingQuality& quality) const {
  const NodeTrajectory& trajectory = seen_->trajectory;
  const std::vector<SE3>& last = trajectory.last().nodes;
  std::vector<SE3> expected = trajectory.predicted(now.model().nodes(), time, config_.prediction.velocity_weight);
  if (config_.use_searches) {
    expected = corrected_prediction(now, seen_->last_found, last, binding_, history_.count(), std::move(expected),
                                    config_.prediction);
  }
  const motion::NodeStates prior = now.states(expected);
  DeformingSelection selection = now.facing(prior);
  selection.add_last_view(seen_->last_found.view, now.model().states(seen_->last_found.origin_to_camera, last));
  DeformingAlignment alignment = now.align(selection, prior, prior);
  quality = now.quality(selection, alignment.nodes);
  const bool was_lost = seen_->gap.is_open();
  if (!config_.use_searches || !(was_lost || is_doubtful(quality) || !is_healthy(quality))) return alignment;
  alignment = Relocalisation::search(now, selection, prior, binding_.bone_driven_nodes(now.model(), history_.count()),
                                     std::move(alignment));
  quality = now.quality(selection, alignment.nodes);
  if (!was_lost && is_healthy(quality)) return alignment;
  alignment = seen_->relocalisation.relocalise(now, trajectory, std::move(alignment));
  quality = now.quality(now.facing(alignment.nodes), alignment.nodes);
  return alignment;
}

bool DeformingTracker::is_healthy(const DeformingQuality& quality) const {
  return quality.inliers >= config_.min_pixels / 2 && quality.inlier_share() >= config_.min_inlier_share &&
         quality.free_space_share() <= config_.max_free_space;
}

bool DeformingTracker::is_doubtful(const DeformingQuality& quality) const {
  return quality.free_space_share() > config_.search.max_free_space_share ||
         (quality.texture_correlation != 0 && quality.texture_correlation < config_.search.min_correlation);
}

void DeformingTracker::accept(const ModelInView& now, double time, DeformingAlignment alignment,
                              const DeformingQuality& quality, std::span<const NearbyObject> objects) {
  CanonicalModel& model = seen_->model;
  NodeTrajectory& trajectory = seen_->trajectory;
  std::vector<SE3> nodes = now.transforms(alignment.nodes);
  const std::vector<std::size_t> separated = find_separated_nodes(
      model.nodes(), model.spacing(), trajectory.last().nodes, nodes, alignment.seen, config_.topology);
  trajectory.add_tracked(std::move(nodes), time);
  if (quality.free_space_share() <= config_.search.max_free_space_share) {
    seen_->relocalisation.add(history_.count(), now.origin_to_camera(), trajectory);
  }
  if (!separated.empty()) alignment.nodes = part_surfaces(now, separated);
  trajectory.add_nodes(model.fuse(now.view(), std::move(alignment.nodes), trajectory.frame_count()));
  binding_.update(model, trajectory, alignment.seen, objects);
}

// The last frame's pose becomes the canonical one; all motion goes on as it was. Nodes that were glued while they
// parted are followed back from here. Returns the nodes' states in the view.
motion::NodeStates DeformingTracker::part_surfaces(const ModelInView& now, std::span<const std::size_t> separated) {
  CanonicalModel& model = seen_->model;
  NodeTrajectory& trajectory = seen_->trajectory;
  const std::vector<SE3> pose = separated_pose(model.nodes(), model.edges(), trajectory.last().nodes, config_.topology);
  trajectory.set_canonical_pose(pose);
  for (const std::size_t node : separated) trajectory.mark_past_extrapolated(node);
  binding_.set_canonical_pose(pose);
  seen_->relocalisation.set_canonical_pose(trajectory);
  model.set_canonical_pose(pose);
  return now.states(trajectory.last().nodes);
}

std::optional<SE3> DeformingTracker::contact_motion_of(int label) const {
  if (!seen_) return std::nullopt;
  return binding_.contact_motion(label, seen_->model, seen_->trajectory);
}

motion::Motion DeformingTracker::motion() const {
  if (!seen_) throw Error(ErrorCode::kFailure, "a layer that was never seen has no motion");
  return motion_of(seen_->model, seen_->trajectory);
}

std::optional<TrackedLayer> DeformingTracker::finish() && {
  if (!seen_) return std::nullopt;
  smooth_backward(history_, label_, seen_->model, binding_, config_.in_view, config_.backward, seen_->trajectory);
  return TrackedLayer{motion_of(seen_->model, seen_->trajectory), seen_->model.edges(), seen_->model.spacing(),
                      binding_.body()};
}

} // namespace kinora::tracking
