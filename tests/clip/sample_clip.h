// Clips with random contents that look like trained ones: parameters near zero, a few large, occupancy in blobs.
#pragma once

#include <string>

#include "clip/clip.h"
#include "core/random.h"
#include "sample_motion.h"

namespace kinora::clip::testing {

inline SE3 random_pose(Random& random) {
  Twist twist;
  for (int i = 0; i < 6; ++i) twist[i] = (random.uniform_double() - 0.5) * (i < 3 ? 4 : 6);
  return exp_se3(twist);
}

inline fields::FieldConfig small_config() {
  fields::FieldConfig config;
  config.box = {Eigen::Vector3d(-0.5, 0.25, 1.0), 1.5};
  config.levels = 4;
  config.log2_table_size = 10;
  config.coarsest_resolution = 6;
  config.finest_resolution = 96;
  config.occupancy_resolution = 64;
  return config;
}

/// Of densities for even seeds, of signed distances for odd ones.
inline fields::Field random_field(std::uint64_t seed, const fields::FieldConfig& config = small_config()) {
  Random random(seed);
  fields::Field field(config);
  if (seed % 2 == 1) {
    field.config.geometry = fields::Geometry::kSignedDistance;
    field.sharpness = 2.5F;
  }
  const auto draw = [&random](double scale) {
    const double outlier = random.below(500) == 0 ? 20 : 1;
    return static_cast<float>(random.normal() * scale * outlier);
  };
  for (float& v : field.table) v = draw(0.1);
  for (float& v : field.density_net) v = draw(0.4);
  for (float& v : field.color_net) v = draw(0.4);
  const int blobs = 1 + static_cast<int>(random.below(3));
  for (int b = 0; b < blobs; ++b) {
    const auto r = static_cast<std::uint32_t>(config.occupancy_resolution);
    const int x = static_cast<int>(random.below(r - 4));
    const int y = static_cast<int>(random.below(r - 4));
    const int z = static_cast<int>(random.below(r - 4));
    for (int i = 0; i < 64; ++i) field.occupancy.set(x + i % 4, y + i / 4 % 4, z + i / 16);
  }
  return field;
}

/// Blocks that were seen from one to three sides.
inline fields::Confidence random_confidence(const fields::Occupancy& occupancy, std::uint64_t seed) {
  Random random(seed, 2);
  fields::Confidence confidence(occupancy);
  for (auto& levels : confidence.levels()) {
    for (std::uint32_t sides = 1 + random.below(3); sides > 0; --sides) {
      levels[random.below(fields::Confidence::kNormals)] =
          static_cast<std::uint8_t>(random.below(fields::Confidence::kMax + 1));
    }
  }
  return confidence;
}

/// The object, as clips once had it, without confidence.
inline Clip sample_clip(std::uint64_t seed, std::size_t frames, bool camera_moves) {
  Random random(seed, 1);
  Clip clip;
  double time = random.uniform_double();
  for (std::size_t i = 0; i < frames; ++i) {
    clip.times.push_back(time);
    time += 0.01 + random.uniform_double() * 0.05;
    clip.capture_frames.push_back(static_cast<int>(3 * i + 1));
    clip.held_out.push_back(i % 10 == 9);
  }
  clip.intrinsics = {640, 480, 525.123456789, 524.9, 319.5, 239.25};
  for (std::size_t i = 0; i < (camera_moves ? frames : 1); ++i) clip.camera_to_world.push_back(random_pose(random));
  clip.layers.push_back({"background", 0, random_field(seed * 10), motion::Motion::still()});
  clip.layers[0].confidence = random_confidence(clip.layers[0].field.occupancy, seed);
  std::vector<motion::Motion::Pose> poses;
  for (std::size_t i = 0; i < frames; ++i) {
    poses.push_back({random_pose(random), static_cast<motion::Health>(random.below(3))});
  }
  clip.layers.push_back({"object", 2, random_field(seed * 10 + 1), motion::Motion::rigid(std::move(poses))});
  clip.metadata = {{"config", {{"preset", "balanced"}, {"seed", 7}}}, {"note", "Ärger"}, {"numbers", {0.1, -1, 1e300}}};
  return clip;
}

/// Joints that wander, two hundredths of a metre from frame to frame.
inline motion::JointPaths random_joints(std::uint64_t seed, std::size_t frames) {
  Random random(seed, 3);
  motion::JointPaths joints;
  std::vector<Eigen::Vector3d> positions;
  for (int j = 0; j < 19; ++j) {
    joints.names.push_back("joint_" + std::to_string(j));
    positions.emplace_back(random.normal(), random.normal(), 2 + random.normal());
  }
  for (std::size_t f = 0; f < frames; ++f) {
    for (Eigen::Vector3d& location : positions) {
      location += 0.02 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    }
    joints.positions.push_back(positions);
  }
  return joints;
}

/// Of so many nodes: the first half is there from the start, others come later, or not in this clip.
inline motion::NodeBirths random_births(std::uint64_t seed, std::size_t nodes, std::size_t frames) {
  Random random(seed, 4);
  std::vector<std::uint32_t> births(nodes, 0);
  for (std::size_t n = nodes / 2; n < nodes; ++n) births[n] = random.below(static_cast<std::uint32_t>(frames + 1));
  return motion::NodeBirths(std::move(births));
}

/// The same with a third layer, which deforms and has a skeleton.
inline Clip bending_clip(std::uint64_t seed, std::size_t frames, bool camera_moves) {
  Clip clip = sample_clip(seed, frames, camera_moves);
  WalkerOptions options;
  options.nodes = 20 + seed;
  options.frames = frames;
  options.seed = seed;
  clip.layers.push_back({"person", 1, random_field(seed * 10 + 2), walker(options)});
  clip.layers.back().joints = random_joints(seed, frames);
  return clip;
}

} // namespace kinora::clip::testing
