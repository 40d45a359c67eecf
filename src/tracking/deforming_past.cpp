// Where nodes of a deforming layer were before the tracker found them: a hand that comes out from behind a box was
// behind it. They are followed back from there; what the camera sees past holds them in hiding.
#include <algorithm>

#include "tracking/deforming_selection.h"
#include "tracking/deforming_tracker.h"
#include "tracking/layer_view.h"

namespace kinora::tracking {
/// What the frame that was looked at before, one of later time, tells those before it.
struct DeformingTracker::Future {
  std::vector<SE3> corrections; ///< for each node: it was at guess · correction
  ObjectView view;              ///< empty before the first
  NodeStates states;            ///< in its camera
};

void DeformingTracker::settle_past() {
  if (births_.empty()) return;
  Future future;
  future.corrections.resize(nodes_.size(), SE3::Identity());
  for (std::size_t number = *std::max_element(births_.begin(), births_.end()); number-- > memory_.begin();) {
    if (records_[number].health == Health::kTracked) follow_back(number, memory_.at(number), future);
  }
}

void DeformingTracker::follow_back(std::size_t number, const ingest::Frame& frame, Future& future) {
  std::vector<SE3>& nodes = records_[number].nodes;
  const std::vector<SE3> guess = nodes;
  ObjectView view = view_layer(frame, label_);
  const SE3 world_to_camera = relative_to_origin(frame);
  const NodeStates guessed = states_in(world_to_camera, guess);
  const auto is_guessed = [&](std::size_t n) { return births_[n] > number; };
  const auto is_mostly_guessed = [&](const Influence& influence) {
    double weight = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      if (is_guessed(static_cast<std::size_t>(influence.nodes[k]))) weight += influence.weights[k];
    }
    return weight > config_.backward.guessed_share;
  };
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (is_guessed(n)) nodes[n] = guess[n] * future.corrections[n];
  }
  const NodeStates start = states_in(world_to_camera, nodes);
  DeformingSelection selection =
      select_facing(surface_.points(), surface_.skin(), view, start, config_.max_points, is_mostly_guessed);
  if (!future.view.empty()) selection.add_last_view(future.view, future.states);
  DeformingAlignmentConfig config = config_.solver;
  config.rigid_iterations = 0;
  config.plane_gate = config_.backward.plane_gate;
  config.prior_sigma = config_.backward.prior_sigma;
  const std::vector<NodePull> binding = body_.pulls(number, frame.camera.camera_to_world.inverse());
  const std::vector<GraphEdge> holding = holding_edges(binding);
  const DeformingAlignment alignment = align_deforming({nodes_, holding, selection.points}, selection.textures, view,
                                                       start, guessed, spacing_, config, binding);
  const SE3 camera_to_world = world_to_camera.inverse();
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!is_guessed(n)) continue;
    nodes[n] = renormalized(camera_to_world * alignment.nodes.transforms[n].to_se3());
    future.corrections[n] = renormalized(guess[n].inverse() * nodes[n]);
  }
  future.states = states_in(world_to_camera, nodes);
  future.view = std::move(view);
}

} // namespace kinora::tracking
