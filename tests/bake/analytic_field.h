// Fields that hold a given shape and colour exactly, without a training: one dense level stores density and colour at
// its vertices, and the nets pass them on.
#pragma once

#include <cmath>

#include "clip/clip.h"

namespace kinora::bake::testing {

/// Cube of 1 m around the origin.
inline fields::FieldConfig unit_config() {
  fields::FieldConfig config;
  config.box = {Eigen::Vector3d::Constant(-0.5), 1.0};
  config.levels = 2;
  config.log2_table_size = 17; // the finer level is dense: 49³ vertices
  config.coarsest_resolution = 8;
  config.finest_resolution = 48;
  config.occupancy_resolution = 64;
  return config;
}

/// Both signs of `count` values pass through a layer of max(0, ·): value i to outputs 2i and 2i + 1.
inline void split_signs(float* weights, int outputs, int first_input, int count) {
  for (int i = 0; i < count; ++i) {
    weights[(first_input + i) * outputs + 2 * i] = 1;
    weights[(first_input + i) * outputs + 2 * i + 1] = -1;
  }
}

inline void join_signs(float* weights, int outputs, int count) {
  for (int i = 0; i < count; ++i) {
    weights[(2 * i) * outputs + i] = 1;
    weights[(2 * i + 1) * outputs + i] = -1;
  }
}

/// `distance(p)`: signed distance to the surface, metres, negative inside; `color(p)`: sRGB in (0, 1).
template <class Distance, class Color> fields::Field field_of(const Distance& distance, const Color& color) {
  const fields::FieldConfig config = unit_config();
  fields::Field field(config);
  const fields::GridLevel level = fields::grid_levels(config).back();
  const int n = level.resolution + 1;
  for (int i = 0; i < n * n * n; ++i) {
    const Eigen::Vector3d p = config.box.origin + config.box.side / level.resolution *
                                                      Eigen::Vector3i(i % n, i / n % n, i / n / n).cast<double>();
    float* entry = field.table.data() + (level.offset + static_cast<std::size_t>(i)) * fields::FieldConfig::kFeatures;
    // At the surface a way of one cell is half opaque.
    const double raw = std::log(4 * std::log(2.0)) - 2 * distance(p) / config.cell_size();
    entry[0] = static_cast<float>(std::clamp(raw, -8.0, 8.0));
    const Eigen::Vector3d rgb = color(p);
    for (int c = 0; c < 3; ++c) entry[c + 1] = static_cast<float>(std::log(rgb[c] / (1 - rgb[c])));
  }
  using fields::FieldConfig;
  split_signs(field.density_net.data(), FieldConfig::kHidden, FieldConfig::kFeatures, 4);
  join_signs(field.density_net.data() + config.encoding_width() * FieldConfig::kHidden, FieldConfig::kGeometry, 4);
  float* net = field.color_net.data();
  split_signs(net, FieldConfig::kColorHidden, 0, 3);
  net += FieldConfig::kGeometry * FieldConfig::kColorHidden;
  for (int i = 0; i < 6; ++i) net[i * FieldConfig::kColorHidden + i] = 1;
  join_signs(net + FieldConfig::kColorHidden * FieldConfig::kColorHidden, FieldConfig::kColorOutputs, 3);
  const int r = config.occupancy_resolution;
  for (int i = 0; i < r * r * r; ++i) {
    const Eigen::Vector3d cell =
        Eigen::Vector3i(i % r, i / r % r, i / r / r).cast<double>() + Eigen::Vector3d::Constant(0.5);
    if (distance(config.box.origin + config.box.side / r * cell) < 0.06)
      field.occupancy.set(i % r, i / r % r, i / r / r);
  }
  return field;
}

constexpr double kRadius = 0.3;

/// A ball, reddish where x < 0 and bluish elsewhere.
inline fields::Field ball_field(const Eigen::Vector3d& centre = Eigen::Vector3d::Zero(), double radius = kRadius) {
  return field_of([&](const Eigen::Vector3d& p) { return (p - centre).norm() - radius; },
                  [](const Eigen::Vector3d& p) {
                    return p.x() < 0 ? Eigen::Vector3d(0.8, 0.2, 0.3) : Eigen::Vector3d(0.2, 0.3, 0.8);
                  });
}

inline SE3 moved(const Eigen::Vector3d& offset, double radians = 0) {
  SE3 pose = SE3::Identity();
  pose.translation() = offset;
  pose.linear() = Eigen::AngleAxisd(radians, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  return pose;
}

inline motion::Motion rigid_motion(int frames) {
  std::vector<motion::Motion::Pose> poses;
  poses.reserve(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) poses.push_back({moved({0.1 * i, -0.05 * i, 0.02 * i}, 0.2 * i)});
  return motion::Motion::rigid(std::move(poses));
}

/// Nodes every 15 cm through the unit cube that bend it around the y axis, more in every frame, and carry it upwards.
inline motion::Motion bending_motion(int frames, double bending_per_frame = 0.3) {
  std::vector<Eigen::Vector3d> nodes;
  nodes.reserve(7 * 7 * 7);
  for (int i = 0; i < 7 * 7 * 7; ++i)
    nodes.emplace_back(0.15 * Eigen::Vector3i(i % 7 - 3, i / 7 % 7 - 3, i / 49 - 3).cast<double>());
  const auto graph = std::make_shared<const motion::DeformationGraph>(nodes, 0.15, 0.35);
  std::vector<motion::Motion::Deformation> deformations;
  for (int f = 0; f < frames; ++f) {
    motion::Motion::Deformation deformation;
    for (const Eigen::Vector3d& p : nodes) {
      const double angle = bending_per_frame * f * p.x();
      SE3 pose = SE3::Identity();
      pose.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
      pose.translation() = Eigen::Vector3d(0, -0.1 * f, 0);
      deformation.node_to_world.push_back(DualQuaternion::from(pose));
    }
    deformations.push_back(std::move(deformation));
  }
  return motion::Motion::deforming(graph, std::move(deformations));
}

/// A still ball, a rigid one to its right and a bending one to its left, `frames` frames at 10 per second.
inline clip::Clip sample_clip(int frames) {
  clip::Clip clip;
  for (int i = 0; i < frames; ++i) {
    clip.times.push_back(0.5 + 0.1 * i);
    clip.capture_frames.push_back(i);
    clip.held_out.push_back(false);
  }
  clip.intrinsics = {64, 48, 60, 60, 31.5, 23.5};
  clip.camera_to_world = {moved({0, 0, -2})};
  clip.layers.push_back({"background", 0, ball_field({0, 0, 0.2}, 0.15), motion::Motion::still()});
  clip.layers.push_back({"object", 2, ball_field({0.3, 0, 0}, 0.1), rigid_motion(frames)});
  clip.layers.push_back({"person", 1, ball_field({-0.3, 0, 0}, 0.1), bending_motion(frames)});
  return clip;
}

} // namespace kinora::bake::testing
