// A textured sheet that bends before a wall, seen by a camera at the origin.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "fields/sampling/pixel_store.h"
#include "motion/motion.h"

namespace kinora::fields {

inline constexpr int kWidth = 96;
inline constexpr int kHeight = 72;
inline constexpr double kDistance = 2.0;
inline constexpr double kHalfWidth = 0.4;
inline constexpr double kHalfHeight = 0.3;
inline constexpr double kWall = 3.0;

/// Where the sheet's point (s, y) is when it is bent about the vertical with a curvature in 1/m: edges come nearer.
inline SE3 sheet_pose(double s, double curvature) {
  const double angle = curvature * s;
  const double x = curvature == 0 ? s : std::sin(angle) / curvature;
  const double z = curvature == 0 ? kDistance : kDistance - (1 - std::cos(angle)) / curvature;
  SE3 pose = SE3::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(x, 0, z) - pose.linear() * Eigen::Vector3d(s, 0, kDistance);
  return pose;
}

inline std::shared_ptr<const motion::DeformationGraph> sheet_graph() {
  std::vector<Eigen::Vector3d> nodes;
  for (int i = -7; i <= 7; ++i) {
    for (int j = -5; j <= 5; ++j) nodes.emplace_back(0.06 * i, 0.06 * j, kDistance);
  }
  return std::make_shared<const motion::DeformationGraph>(nodes, 0.075, 0.15);
}

inline std::vector<DualQuaternion> sheet_nodes(const motion::DeformationGraph& graph, double curvature) {
  std::vector<DualQuaternion> nodes;
  for (const auto& node : graph.nodes()) nodes.push_back(DualQuaternion::from(sheet_pose(node.x(), curvature)));
  return nodes;
}

/// What a camera at the origin sees of the sheet (label 1) before a wall (label 0).
inline ingest::Frame sheet_frame(int index, double curvature) {
  ingest::Frame f;
  f.index = index;
  f.camera.intrinsics = {kWidth, kHeight, 100, 100, (kWidth - 1) / 2.0, (kHeight - 1) / 2.0};
  f.color = ColorImage(kWidth, kHeight, 3);
  f.depth = DepthImage(kWidth, kHeight);
  f.labels = LabelImage(kWidth, kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Eigen::Vector3d d = f.camera.intrinsics.unproject(u, v, 1);
      double depth = kDistance;
      double s = depth * d.x();
      if (curvature > 0) { // the far side of a cylinder around the camera's axis
        const double radius = 1 / curvature;
        const double centre = kDistance - radius;
        const double a = d.x() * d.x() + 1;
        depth = (centre + std::sqrt(centre * centre - a * (centre * centre - radius * radius))) / a;
        s = radius * std::atan2(depth * d.x(), depth - centre);
      }
      const double y = depth * d.y();
      const bool sheet = std::abs(s) < kHalfWidth && std::abs(y) < kHalfHeight;
      const double wave = 0.5 + 0.4 * std::sin(18 * s) * std::cos(18 * y);
      const Eigen::Vector3d rgb = sheet ? Eigen::Vector3d(wave, 0.3, 1 - wave) : Eigen::Vector3d(0.2, 0.5, 0.4);
      for (int c = 0; c < 3; ++c) f.color.at(u, v, c) = static_cast<std::uint8_t>(std::lround(255 * rgb[c]));
      f.depth.at(u, v) = static_cast<float>(sheet ? depth : kWall);
      f.labels.at(u, v) = sheet ? 1 : 0;
    }
  }
  f.clean_depth = f.depth;
  return f;
}

inline double curvature_at(int frame) { return 0.15 * frame; }

/// Nine frames of bending; every fourth is not trained on.
struct Performance {
  PixelStore store{1'000'000, 9};
  motion::Motion motion = motion::Motion::still();

  Performance() {
    const auto graph = sheet_graph();
    std::vector<motion::Motion::Deformation> deformations;
    for (int i = 0; i < 9; ++i) {
      if (i % 4 != 3) store.add(sheet_frame(i, curvature_at(i)), i);
      deformations.push_back({sheet_nodes(*graph, curvature_at(i)), motion::Health::kTracked});
    }
    motion = motion::Motion::deforming(graph, std::move(deformations));
  }
};

} // namespace kinora::fields
