#include "bake/skinning.h"

#include <algorithm>
#include <limits>

#include "core/error.h"

namespace kinora::bake {
namespace {

SE3 translation_by(const Eigen::Vector3d& offset) {
  SE3 transform = SE3::Identity();
  transform.translation() = offset;
  return transform;
}

/// Fills joints and weights; returns the node of each joint.
std::vector<int> attach_to_nodes(const motion::DeformationGraph& graph, host::Mesh& mesh) {
  std::vector<motion::Influence> influences;
  std::vector<int> joint_of(graph.nodes().size(), -1);
  for (const Eigen::Vector3f& p : mesh.positions) {
    influences.push_back(graph.influence(p.cast<double>()));
    const motion::Influence& influence = influences.back();
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      joint_of[static_cast<std::size_t>(influence.nodes[k])] = 0;
    }
  }
  std::vector<int> nodes;
  for (std::size_t node = 0; node < joint_of.size(); ++node) {
    if (joint_of[node] < 0) continue;
    joint_of[node] = static_cast<int>(nodes.size());
    nodes.push_back(static_cast<int>(node));
  }
  if (nodes.size() > std::numeric_limits<std::uint16_t>::max()) {
    throw Error(ErrorCode::kFailure, "the layer " + mesh.name + " has more than 65535 nodes, which no skin can name");
  }
  for (const motion::Influence& influence : influences) {
    std::array<std::uint16_t, 4> joints{};
    std::array<float, 4> weights{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
      if (!(influence.weights[k] > 0)) continue;
      joints[k] = static_cast<std::uint16_t>(joint_of[static_cast<std::size_t>(influence.nodes[k])]);
      weights[k] = static_cast<float>(influence.weights[k]);
    }
    if (influence.count == 0) weights[0] = 1; // on the edge of the nodes' reach, where rounding decides
    mesh.skin.joints.push_back(joints);
    mesh.skin.weights.push_back(weights);
  }
  return nodes;
}

Eigen::Vector3d middle_of(const host::Mesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : mesh.positions) sum += p.cast<double>();
  return sum / static_cast<double>(std::max<std::size_t>(1, mesh.positions.size()));
}

} // namespace

Skinning::Skinning(const motion::Motion& motion, host::Mesh& mesh) : motion_(motion) {
  mesh.skin = {};
  if (motion.kind() == motion::MotionKind::kRigid) {
    inverse_bind_.push_back(translation_by(-middle_of(mesh)));
  } else if (motion.kind() == motion::MotionKind::kDeforming) {
    nodes_ = attach_to_nodes(*motion.graph(), mesh);
    for (const int node : nodes_) {
      inverse_bind_.push_back(translation_by(-motion.graph()->nodes()[static_cast<std::size_t>(node)]));
    }
  }
  mesh.skin.inverse_bind = inverse_bind_;
}

std::vector<SE3> Skinning::joints_at(int frame) const {
  std::vector<SE3> joints;
  if (motion_.kind() == motion::MotionKind::kRigid) {
    joints.emplace_back(motion_.canonical_to_world(frame) * inverse_bind_.front().inverse());
  } else if (motion_.kind() == motion::MotionKind::kDeforming) {
    const auto last = static_cast<int>(motion_.deformations().size()) - 1;
    const auto& deformation = motion_.deformations()[static_cast<std::size_t>(std::clamp(frame, 0, last))];
    for (std::size_t j = 0; j < nodes_.size(); ++j) {
      joints.emplace_back(deformation.node_to_world[static_cast<std::size_t>(nodes_[j])].to_se3() *
                          inverse_bind_[j].inverse());
    }
  }
  return joints;
}

Skinning::Difference Skinning::blending_difference(const host::Mesh& mesh, std::span<const int> frames) const {
  constexpr std::size_t kMaxVertices = 3000;
  Difference difference;
  if (motion_.kind() != motion::MotionKind::kDeforming) return difference;
  const std::size_t stride = std::max<std::size_t>(1, mesh.positions.size() / kMaxVertices);
  std::size_t count = 0;
  for (const int frame : frames) {
    const motion::Warp warp = motion_.warp(frame);
    const std::vector<SE3> joints = joints_at(frame);
    for (std::size_t v = 0; v < mesh.positions.size(); v += stride) {
      const Eigen::Vector3d canonical = mesh.positions[v].cast<double>();
      const auto blended = warp.to_world(canonical);
      if (!blended) continue;
      Eigen::Vector3d linear = Eigen::Vector3d::Zero();
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t joint = mesh.skin.joints[v][k];
        linear += mesh.skin.weights[v][k] * (joints[joint] * (inverse_bind_[joint] * canonical));
      }
      const double distance = (linear - *blended).norm();
      difference.mean += distance;
      difference.largest = std::max(difference.largest, distance);
      ++count;
    }
  }
  if (count > 0) difference.mean /= static_cast<double>(count);
  return difference;
}

} // namespace kinora::bake
