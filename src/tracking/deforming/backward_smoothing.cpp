#include "tracking/deforming/backward_smoothing.h"

#include <algorithm>
#include <optional>

#include "tracking/view/layer_view.h"

namespace kinora::tracking {
namespace {

/// What the frame that was looked at before, one of later time, tells those before it.
struct Later {
  std::vector<SE3> corrections; ///< for each node: it was at guess · correction
  ObjectView view;              ///< empty before the first
  motion::NodeStates states;    ///< in its camera
};

// Where the nodes were in one frame.
std::vector<SE3> followed_back(const ModelInView& now, const NodeTrajectory& trajectory, std::size_t number,
                               double guessed_share, Later& later) {
  const std::vector<SE3>& guess = trajectory.at(number).nodes;
  const auto is_guess = [&](std::size_t n) { return trajectory.is_guess(n, number); };
  const auto is_mostly_guessed = [&](const motion::Influence& influence) {
    double weight = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      if (is_guess(static_cast<std::size_t>(influence.nodes[k]))) weight += influence.weights[k];
    }
    return weight > guessed_share;
  };
  std::vector<SE3> nodes = guess;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (is_guess(n)) nodes[n] = guess[n] * later.corrections[n];
  }
  const motion::NodeStates start = now.states(nodes);
  DeformingSelection selection = now.facing(start, is_mostly_guessed);
  if (!later.view.empty()) selection.add_last_view(later.view, later.states);
  const std::vector<SE3> aligned = now.transforms(now.align(selection, start, now.states(guess)).nodes);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!is_guess(n)) continue;
    nodes[n] = aligned[n];
    later.corrections[n] = renormalized(guess[n].inverse() * nodes[n]);
  }
  later.states = now.states(nodes);
  return nodes;
}

} // namespace

void smooth_backward(const FrameMemory& frames, int label, const CanonicalModel& model, const LayerBinding& binding,
                     const ModelInViewConfig& in_view, const BackwardSmoothingConfig& config,
                     NodeTrajectory& trajectory) {
  ModelInViewConfig held = in_view;
  held.solver.rigid_iterations = 0;
  held.solver.plane_gate = config.plane_gate;
  held.solver.prior_sigma = config.prior_sigma;
  Later later;
  later.corrections.resize(model.nodes().size(), SE3::Identity());
  const std::size_t begin = std::max(frames.begin(), trajectory.first());
  for (std::size_t number = trajectory.first_without_guess(); number-- > begin;) {
    if (trajectory.at(number).health != motion::Health::kTracked) continue;
    const ingest::Frame frame = frames.at(number);
    ObjectView view = view_layer(frame, label);
    const SE3& camera_to_world = frame.camera.camera_to_world;
    const ModelInView now(model, view, camera_to_world, binding.ties(model, number, camera_to_world.inverse()), held);
    trajectory.correct(number, followed_back(now, trajectory, number, config.guessed_share, later));
    later.view = std::move(view);
  }
}

} // namespace kinora::tracking
