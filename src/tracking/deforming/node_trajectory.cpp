#include "tracking/deforming/node_trajectory.h"

#include <algorithm>
#include <array>

#include "tracking/rigid/constant_velocity.h"

namespace kinora::tracking {
namespace {

SE3 blended(std::span<const SE3> nodes, const motion::Influence& influence) {
  std::array<DualQuaternion, motion::Influence::kMax> transforms;
  const auto count = static_cast<std::size_t>(influence.count);
  for (std::size_t k = 0; k < count; ++k) {
    transforms[k] = DualQuaternion::from(nodes[static_cast<std::size_t>(influence.nodes[k])]);
  }
  return blend(std::span(transforms).first(count), std::span(influence.weights).first(count)).to_se3();
}

} // namespace

NodeTrajectory::NodeTrajectory(std::size_t first, std::size_t nodes, double time)
    : first_(first), frames_{{std::vector<SE3>(nodes, SE3::Identity()), motion::Health::kTracked, time}},
      first_observed_(nodes, first) {}

void NodeTrajectory::add_tracked(std::vector<SE3> nodes, double time) {
  frames_.push_back({std::move(nodes), motion::Health::kTracked, time});
}

void NodeTrajectory::add_untracked(motion::Health health, double time) {
  frames_.push_back({last().nodes, health, time});
}

std::vector<SE3> NodeTrajectory::predicted(std::span<const Eigen::Vector3d> canonical, double time,
                                           double velocity_weight) const {
  const Frame& last = frames_.back();
  if (frames_.size() < 2 || last.health != motion::Health::kTracked) return last.nodes;
  const Frame& earlier = frames_[frames_.size() - 2];
  if (earlier.health != motion::Health::kTracked) return last.nodes;
  const double steps = velocity_weight * steps_ahead(earlier.time, last.time, time);
  std::vector<SE3> result;
  result.reserve(last.nodes.size());
  for (std::size_t n = 0; n < last.nodes.size(); ++n) {
    result.push_back(extrapolated(earlier.nodes[n], last.nodes[n], canonical[n], steps));
  }
  return result;
}

void NodeTrajectory::add_nodes(const GraphGrowth& growth) {
  for (Frame& frame : frames_) {
    for (const std::size_t node : growth.attached) frame.nodes.push_back(SE3(frame.nodes[node]));
    for (const motion::Influence& influence : growth.grown) frame.nodes.push_back(blended(frame.nodes, influence));
  }
  first_observed_.resize(last().nodes.size(), frame_count() - 1);
}

std::size_t NodeTrajectory::first_without_extrapolation() const {
  return first_observed_.empty() ? first_ : *std::max_element(first_observed_.begin(), first_observed_.end());
}

void NodeTrajectory::set_canonical_pose(std::span<const SE3> pose) {
  for (Frame& frame : frames_) {
    for (std::size_t n = 0; n < frame.nodes.size(); ++n) {
      frame.nodes[n] = renormalized(frame.nodes[n] * pose[n].inverse());
    }
  }
}

std::vector<motion::Motion::Deformation> NodeTrajectory::deformations(const Eigen::Vector3d& origin) const {
  const auto in_world = [&](const Frame& frame, motion::Health health) {
    motion::Motion::Deformation deformation;
    deformation.health = health;
    for (const SE3& node : frame.nodes) {
      deformation.node_to_world.push_back(
          DualQuaternion::from(SE3(Eigen::Translation3d(origin) * node * Eigen::Translation3d(-origin))));
    }
    return deformation;
  };
  std::vector<motion::Motion::Deformation> result;
  result.reserve(frame_count());
  if (first_ > 0) result.assign(first_, in_world(frames_.front(), motion::Health::kLost));
  for (const Frame& frame : frames_) result.push_back(in_world(frame, frame.health));
  return result;
}

} // namespace kinora::tracking
