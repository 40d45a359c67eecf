// What tests of drawing look at, and from where.
#pragma once

#include <cmath>
#include <memory>

#include "core/camera.h"
#include "core/random.h"
#include "motion/warp.h"
#include "painted_field.h"

namespace kinora::fields::testing {

// Cells of 16 mm. The surface is drawn where its density has taken half of the light: within a cell behind it.
inline const FieldBox kBox{Eigen::Vector3d::Constant(-0.5), 1};
inline constexpr double kCell = 1.0 / kPaintedCells;

/// Looks at `target` from `position`; 45° to each side.
inline Camera camera_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target, int width = 96,
                        int height = 72) {
  Camera camera;
  camera.intrinsics = {width, height, width / 2.0, width / 2.0, (width - 1) / 2.0, (height - 1) / 2.0};
  const Eigen::Vector3d forward = (target - position).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(forward).normalized();
  camera.camera_to_world = SE3::Identity();
  camera.camera_to_world.linear() << right, forward.cross(right), forward;
  camera.camera_to_world.translation() = position;
  return camera;
}

/// Not in rows: where more nodes are equally near than may move a point, none does.
inline std::shared_ptr<const motion::DeformationGraph> graph_of_box() {
  Random random(11);
  const auto coordinate = [&random](int number) { return 0.1 * number - 0.5 + 0.05 * random.uniform_double(); };
  constexpr int kNodes = 11 * 11 * 11;
  std::vector<Eigen::Vector3d> nodes;
  nodes.reserve(kNodes);
  for (int i = 0; i < kNodes; ++i) {
    nodes.emplace_back(coordinate(i % 11), coordinate(i / 11 % 11), coordinate(i / 121));
  }
  return std::make_shared<const motion::DeformationGraph>(nodes, 0.15, 0.3);
}

/// A floor that is not level: steps of its hull lie before it.
inline Field sloping_floor() {
  return painted_field(kBox, [](const Eigen::Vector3d& at) { return Paint{at.y() - 0.02 * at.x() - 0.05 * at.z()}; });
}
/// Sees nothing but sloping_floor(), grazes it, and is so far away that the place of an entry errs: i from 0 to 23.
inline Camera camera_that_grazes(int i) {
  const double angle = 0.1 + 0.01 * i;
  const Eigen::Vector3d from(0.1 * i, 7 * std::sin(angle), -7 * std::cos(angle));
  Camera camera = camera_at(from, {0, 0, 0}, 320, 48);
  camera.intrinsics.fx = camera.intrinsics.fy = 10.0 * camera.intrinsics.width;
  return camera;
}

} // namespace kinora::fields::testing
