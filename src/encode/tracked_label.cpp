#include "encode/tracked_label.h"

#include <algorithm>
#include <cmath>

namespace kinora::encode {
namespace {

/// A rigid layer whose points stay within this distance (metres) of their first place is stored as still.
constexpr double kStaticDisplacement = 0.004;

// A deforming layer is followed from its first frame on; before that it is lost, or goes as a rigid thing.
motion::Motion with_frames_before(const motion::Motion& motion, const std::vector<motion::Motion::Pose>& poses) {
  std::vector<motion::Motion::Deformation> all;
  for (const auto& pose : poses) {
    all.push_back(motion.deformations().front());
    all.back().health = pose.health;
    if (pose.health == motion::Health::kLost) continue;
    const DualQuaternion to_frame = DualQuaternion::from(pose.canonical_to_world);
    for (DualQuaternion& node : all.back().node_to_world) node = to_frame * node;
  }
  all.insert(all.end(), motion.deformations().begin(), motion.deformations().end());
  return motion::Motion::deforming(motion.graph(), std::move(all));
}

} // namespace

motion::Motion TrackedLabel::motion() const {
  if (deforming_tracker) return with_frames_before(deforming_tracker->motion(), poses);
  if (layer) return with_frames_before(layer->motion, poses);
  const bool moves = !poses.empty() && max_displacement() > kStaticDisplacement;
  return moves ? motion::Motion::rigid(poses) : motion::Motion::still();
}

void TrackedLabel::move_world(const std::vector<SE3>& moves) {
  world_moves.resize(moves.size(), SE3::Identity());
  for (std::size_t f = 0; f < moves.size(); ++f) world_moves[f] = moves[f] * world_moves[f];
  for (std::size_t f = 0; f < poses.size(); ++f)
    poses[f].canonical_to_world = renormalized(moves[f] * poses[f].canonical_to_world);
  if (!layer) return;
  std::vector<motion::Motion::Deformation> deformations = layer->motion.deformations();
  for (std::size_t i = 0; i < deformations.size(); ++i) {
    const DualQuaternion move = DualQuaternion::from(moves[poses.size() + i]);
    for (DualQuaternion& node : deformations[i].node_to_world) node = move * node;
  }
  layer->motion = motion::Motion::deforming(layer->motion.graph(), std::move(deformations));
}

std::optional<motion::JointPaths> TrackedLabel::joints() const {
  auto joints = layer ? layer->body.joint_paths() : std::nullopt;
  if (!joints) return std::nullopt;
  auto& positions = joints->positions;
  positions.insert(positions.begin(), static_cast<std::size_t>(first_frame), positions.front());
  for (std::size_t f = 0; f < world_moves.size(); ++f) {
    for (Eigen::Vector3d& position : positions[f]) position = world_moves[f] * position;
  }
  return joints;
}

double TrackedLabel::max_displacement() const {
  double largest = 0;
  for (const auto& pose : poses) {
    if (pose.health == motion::Health::kLost) continue;
    const double shift = (pose.canonical_to_world * centre - centre).norm();
    const double rotational_displacement = 2 * std::sin(rotation_angle(pose.canonical_to_world) / 2) * radius;
    largest = std::max(largest, shift + rotational_displacement);
  }
  return largest;
}

} // namespace kinora::encode
