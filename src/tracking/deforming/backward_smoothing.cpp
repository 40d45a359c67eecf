#include "tracking/deforming/backward_smoothing.h"

#include <algorithm>
#include <optional>

#include "tracking/view/deforming_view.h"

namespace kinora::tracking {
namespace {

/// What the frame that was looked at before, one of later time, tells those before it.
struct Later {
  std::vector<SE3> corrections; ///< for each node: it was at guess · correction
  LayerView view;               ///< empty before the first
  motion::NodeStates states;    ///< in its camera
};

// Where the nodes were in one frame.
std::vector<SE3> followed_back(const ModelInView& now, const NodeTrajectory& trajectory, std::size_t number,
                               double extrapolated_share, Later& later) {
  const std::vector<SE3>& guess = trajectory.at(number).nodes;
  const auto is_extrapolated = [&](std::size_t n) { return trajectory.is_extrapolated(n, number); };
  const auto is_mostly_extrapolated = [&](const motion::Influence& influence) {
    double weight = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      if (is_extrapolated(static_cast<std::size_t>(influence.nodes[k]))) weight += influence.weights[k];
    }
    return weight > extrapolated_share;
  };
  std::vector<SE3> nodes = guess;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (is_extrapolated(n)) nodes[n] = guess[n] * later.corrections[n];
  }
  const motion::NodeStates start = now.states(nodes);
  DeformingSelection selection = now.facing(start, is_mostly_extrapolated);
  if (!later.view.empty()) selection.add_last_view(later.view, later.states);
  const std::vector<SE3> aligned = now.transforms(now.align(selection, start, now.states(guess)).nodes);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!is_extrapolated(n)) continue;
    nodes[n] = aligned[n];
    later.corrections[n] = renormalized(guess[n].inverse() * nodes[n]);
  }
  later.states = now.states(nodes);
  return nodes;
}

} // namespace

void smooth_backward(const FrameHistory& frames, int label, const CanonicalModel& model, const LayerBinding& binding,
                     const ModelInViewConfig& in_view, const BackwardSmoothingConfig& config,
                     NodeTrajectory& trajectory) {
  ModelInViewConfig contact = in_view;
  contact.solver.rigid_iterations = 0;
  contact.solver.plane_gate = config.plane_gate;
  contact.solver.prior_sigma = config.prior_sigma;
  Later later;
  later.corrections.resize(model.nodes().size(), SE3::Identity());
  const std::size_t begin = std::max(frames.begin(), trajectory.first());
  for (std::size_t number = trajectory.first_without_extrapolation(); number-- > begin;) {
    if (trajectory.at(number).health != motion::Health::kTracked) continue;
    const ingest::Frame frame = frames.at(number);
    LayerView view = view_layer(frame, label);
    const SE3& camera_to_world = frame.camera.camera_to_world;
    const ModelInView now(model, view, camera_to_world, binding.constraints(model, number, camera_to_world.inverse()),
                          contact);
    trajectory.correct(number, followed_back(now, trajectory, number, config.extrapolated_share, later));
    later.view = std::move(view);
  }
}

} // namespace kinora::tracking
