#include "motion/motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace kinora::motion {
namespace {

/// Frames before and after a fractional frame number, and how far it lies between them.
struct Between {
  std::size_t before;
  std::size_t after;
  double fraction;
};

Between between(double frame, std::size_t count) {
  const double last = static_cast<double>(count - 1);
  const double clamped = frame > 0 ? std::min(frame, last) : 0; // NaN goes to the first frame
  const double whole = std::floor(clamped);
  const auto before = static_cast<std::size_t>(whole);
  return {before, std::min(before + 1, count - 1), clamped - whole};
}

} // namespace

std::string_view name_of(MotionKind kind) {
  switch (kind) {
  case MotionKind::kStill:
    return "still";
  case MotionKind::kRigid:
    return "rigid";
  case MotionKind::kDeforming:
    return "deforming";
  }
  throw Error(ErrorCode::kFailure, "a motion is none of still, rigid and deforming; the clip is damaged");
}

std::string_view name_of(Health health) {
  switch (health) {
  case Health::kTracked:
    return "tracked";
  case Health::kHeld:
    return "held";
  case Health::kLost:
    return "lost";
  }
  throw Error(ErrorCode::kFailure, "a pose has a health that is none of tracked, held and lost; the clip is damaged");
}

Motion Motion::rigid(std::vector<Pose> poses) {
  if (poses.empty()) throw Error(ErrorCode::kFailure, "a rigid motion needs a pose for at least one frame");
  Motion motion(MotionKind::kRigid);
  motion.poses_ = std::move(poses);
  return motion;
}

Motion Motion::deforming(std::shared_ptr<const DeformationGraph> graph, std::vector<Deformation> deformations) {
  const auto fits = [&graph](const Deformation& d) { return d.node_to_world.size() == graph->nodes().size(); };
  if (graph == nullptr || deformations.empty() || !std::all_of(deformations.begin(), deformations.end(), fits)) {
    throw Error(ErrorCode::kFailure,
                "a deforming motion needs a graph, and for each of at least one frame a transform per node");
  }
  Motion motion(MotionKind::kDeforming);
  motion.graph_ = std::move(graph);
  motion.deformations_ = std::move(deformations);
  return motion;
}

SE3 Motion::canonical_to_world(double frame) const {
  if (kind_ == MotionKind::kStill) return SE3::Identity();
  if (kind_ == MotionKind::kDeforming) {
    throw Error(ErrorCode::kFailure, "a deforming layer was asked for a single transform");
  }
  const auto [before, after, fraction] = between(frame, poses_.size());
  if (fraction == 0) return poses_[before].canonical_to_world;
  return interpolate(poses_[before].canonical_to_world, poses_[after].canonical_to_world, fraction);
}

Warp Motion::warp(double frame) const {
  if (kind_ != MotionKind::kDeforming) return Warp(canonical_to_world(frame));
  const auto [before, after, fraction] = between(frame, deformations_.size());
  if (fraction == 0) return {graph_, deformations_[before].node_to_world};
  std::vector<DualQuaternion> nodes;
  for (std::size_t i = 0; i < graph_->nodes().size(); ++i) {
    nodes.push_back(DualQuaternion::from(interpolate(deformations_[before].node_to_world[i].to_se3(),
                                                     deformations_[after].node_to_world[i].to_se3(), fraction)));
  }
  return {graph_, std::move(nodes)};
}

Health Motion::health(std::size_t frame) const {
  switch (kind_) {
  case MotionKind::kRigid:
    return poses_[std::min(frame, poses_.size() - 1)].health;
  case MotionKind::kDeforming:
    return deformations_[std::min(frame, deformations_.size() - 1)].health;
  case MotionKind::kStill:
    break;
  }
  return Health::kTracked;
}

} // namespace kinora::motion
