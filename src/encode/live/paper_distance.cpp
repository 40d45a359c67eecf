#include "encode/live/paper_distance.h"

#include <algorithm>
#include <cmath>

namespace kinora::encode {

PaperView paper_view(const ingest::Frame& frame, const motion::Motion& motion, int timeline_index) {
  constexpr double kEpsilon = 0.01; // metres
  const motion::Warp warp = motion.warp(timeline_index);
  const SE3 world_to_camera = frame.camera.camera_to_world.inverse();
  PaperView view;
  if (warp.is_rigid()) {
    view.translation = (world_to_camera * warp.rigid()).translation();
    return view;
  }
  for (const DualQuaternion& node : warp.node_to_world()) view.rotations.push_back(node.real);
  for (const Eigen::Vector3d& node : warp.node_positions()) {
    const Eigen::Vector3d at = world_to_camera * node;
    const Eigen::Vector2d pixel = frame.camera.intrinsics.project(at);
    const bool is_before = at.z() > 0 && pixel.allFinite() && pixel.cwiseAbs().maxCoeff() < 1e6;
    const int u = is_before ? static_cast<int>(std::lround(pixel.x())) : -1;
    const int v = is_before ? static_cast<int>(std::lround(pixel.y())) : -1;
    view.visible.push_back(frame.depth.contains(u, v) && std::abs(at.z() - frame.depth.at(u, v)) < kEpsilon);
  }
  return view;
}

double paper_distance(const PaperView& a, const PaperView& b, int frames_apart) {
  constexpr double kPose = 8 * 0.1 + 16 * 0.02; // of 24 joints, eight of them the torso's
  constexpr double kVisibility = 0.01;
  constexpr double kTime = 0.02;
  constexpr double kTranslation = 1;
  const double time = kTime * frames_apart * frames_apart;
  const std::size_t nodes = std::min(a.visible.size(), b.visible.size());
  if (nodes == 0) return kTranslation * (a.translation - b.translation).squaredNorm() + time;
  double squares = 0;
  double differing = 0;
  for (std::size_t n = 0; n < nodes; ++n) {
    squares += std::pow(a.rotations[n].angularDistance(b.rotations[n]), 2);
    if (a.visible[n] != b.visible[n]) differing += 1;
  }
  return kPose * squares / static_cast<double>(nodes) + kVisibility * differing + time;
}

} // namespace kinora::encode
