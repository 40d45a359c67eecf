#include "room_scene.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/random.h"
#include "core/sensor_noise.h"

namespace kinora::tracking::testing {
namespace {

struct PosedBox {
  Shape shape;
  SE3 to_world;
};

std::vector<PosedBox> furniture() {
  return {
      {{ShapeKind::kBox, {0.4, 0.4, 0.3}}, pose_at({-0.8, 0.6, 1.9}, 0, 25)},
      {{ShapeKind::kBox, {0.3, 0.9, 0.3}}, pose_at({1.0, 0.3, 2.2}, 0, -20)},
      {{ShapeKind::kBox, {0.5, 0.4, 0.5}}, pose_at({0.2, 0.6, -1.3}, 0, 40)},
  };
}

struct Hit {
  double z = 1e9;
  double grey = 0.5;
  std::uint8_t label = 0;
};

// Waves of some decimetres, no two places alike.
double pattern(const Eigen::Vector3d& p) {
  return 0.45 + 0.1 * (std::sin(17 * p.x() + 7 * p.y()) + std::sin(-6 * p.x() + 19 * p.y() + 4 * p.z()) +
                       std::sin(15 * p.z() - 8 * p.x()) + std::sin(21 * p.z() + 9 * p.y() + 1));
}

void meet(double z, Eigen::Vector3d point, const RoomOptions& options, std::uint8_t label, Hit& hit) {
  if (!(z > 0.05 && z < hit.z)) return;
  if (options.alike > 0) point.x() -= options.alike * std::floor(point.x() / options.alike);
  hit = {z, options.textured ? pattern(point) : 0.5, label};
}

// One in each period, before the wall at z = 3.
std::vector<PosedBox> alike_furniture(double period) {
  std::vector<PosedBox> boxes;
  for (double x = -2.5 * period; x < 2; x += period) {
    boxes.push_back({{ShapeKind::kBox, {0.15, 0.3, 0.15}}, pose_at({x, 0.2, 2.7}, 0, 30)});
  }
  return boxes;
}

Hit look(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray, const RoomOptions& options,
         std::span<const PosedBox> boxes) {
  Hit hit;
  const Eigen::Vector3d low(-2, -1.3, -2);
  const Eigen::Vector3d high(2, 1, 3);
  for (int axis = 0; axis < 3; ++axis) {
    if (options.only_wall) break;
    const double z = ((ray[axis] > 0 ? high : low)[axis] - eye[axis]) / ray[axis];
    meet(z, eye + z * ray, options, 0, hit);
  }
  if (options.only_wall) {
    RoomOptions bare = options;
    bare.textured = false;
    meet((2 - eye.z()) / ray.z(), eye, bare, 0, hit);
  }
  const auto meet_box = [&](const PosedBox& posed, std::uint8_t label) {
    const SE3 inverse = posed.to_world.inverse();
    const auto z = intersect(posed.shape, inverse * eye, inverse.linear() * ray);
    // What moves carries its texture along.
    if (z) meet(*z, label == 0 ? eye + *z * ray : inverse * (eye + *z * ray), options, label, hit);
  };
  if (options.furnished && !options.only_wall) {
    for (const PosedBox& posed : boxes) meet_box(posed, 0);
  }
  if (options.mover) meet_box({{ShapeKind::kBox, {0.25, 0.25, 0.25}}, *options.mover}, 1);
  return hit;
}

} // namespace

ingest::Frame render_room(const SE3& camera_to_world, int index, const RoomOptions& options) {
  SceneOptions size;
  size.width = options.width;
  size.height = options.height;
  size.focal = options.focal;
  ingest::Frame frame = grey_frame(camera_to_world, index, size);
  Random random(options.seed, static_cast<std::uint64_t>(index));
  const std::vector<PosedBox> boxes = options.alike > 0 ? alike_furniture(options.alike) : furniture();
  for (int v = 0; v < options.height; ++v) {
    const SE3 row_to_world = camera_to_world * exp_se3(row_time(v, options.height) * options.readout);
    for (int u = 0; u < options.width; ++u) {
      const Eigen::Vector3d ray = row_to_world.linear() * frame.camera.intrinsics.unproject(u, v, 1.0);
      const Hit hit = look(row_to_world.translation(), ray, options, boxes);
      const double level = 255 * (options.covered ? 0 : options.light) * hit.grey + random.normal();
      for (int c = 0; c < 3; ++c) frame.color.at(u, v, c) = static_cast<std::uint8_t>(std::clamp(level, 0.0, 255.0));
      const double sigma = kSensorNoise.sigma(hit.z);
      const double squared = frame.camera.intrinsics.unproject(u, v, 1.0).head<2>().squaredNorm();
      const double z = hit.z * (1 + options.bow * squared) + options.noise * sigma * random.normal();
      frame.depth.at(u, v) = options.covered ? 0.0F : static_cast<float>(z);
      frame.labels.at(u, v) = options.mover_has_label ? hit.label : 0;
    }
  }
  frame.clean_depth = frame.depth;
  return frame;
}

} // namespace kinora::tracking::testing
