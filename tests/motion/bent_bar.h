// A bar that bends along an arc, as a deformation graph.
#pragma once

#include <memory>
#include <vector>

#include "motion/warp.h"

namespace kinora::motion {

/// A bar of 1 m along x with nodes every 5 cm, bent by `angle` over its length and carried `far` away.
struct BentBar {
  std::shared_ptr<const DeformationGraph> graph;
  std::vector<DualQuaternion> nodes;

  explicit BentBar(double angle, double far = 0) {
    std::vector<Eigen::Vector3d> positions;
    for (int i = 0; i <= 20; ++i) {
      for (const double y : {0.0, 0.05}) positions.emplace_back(0.05 * i, y, 0);
    }
    graph = std::make_shared<const DeformationGraph>(positions, 0.06, 0.12);
    for (const Eigen::Vector3d& p : positions) {
      // Along an arc: position and turn at arc length x.
      const double angle_at = angle * p.x();
      const double x = angle == 0 ? p.x() : std::sin(angle_at) / angle;
      const double z = angle == 0 ? 0 : (1 - std::cos(angle_at)) / angle;
      SE3 pose = SE3::Identity();
      pose.linear() = Eigen::AngleAxisd(-angle_at, Eigen::Vector3d::UnitY()).toRotationMatrix();
      pose.translation() = Eigen::Vector3d(x + far, 0, z) - pose.linear() * Eigen::Vector3d(p.x(), 0, 0);
      nodes.push_back(DualQuaternion::from(pose));
    }
  }
  Warp warp() const { return {graph, nodes}; }
};

} // namespace kinora::motion
