// What a detector of joints may say of a person whose joints are known: with noise, misses, outliers, and left and
// right mistaken.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/camera.h"
#include "core/image.h"
#include "core/random.h"
#include "ingest/frame/joint_detection.h"

namespace kinora::tracking::testing {

struct DetectorErrors {
  double noise = 5;         ///< pixels; three times as many where something hides the joint, and half the score
  double outliers = 0.1;    ///< share of joints that are found anywhere about the person
  double misses = 0.1;      ///< share of joints that are not found
  double swaps = 0;         ///< share of frames in which left and right are exchanged
  bool knows_hidden = true; ///< false: what is hidden is not found
};

/// In the camera; nothing: not known.
using JointPositions = std::array<std::optional<Eigen::Vector3d>, ingest::kDetectedJoints>;

inline ingest::DetectedJoints detect_joints(const JointPositions& positions, const Intrinsics& camera,
                                            const DepthImage& depth, const DetectorErrors& errors, std::uint64_t seed) {
  constexpr double kInside = 0.15; // metres from skin to joint
  Random random(seed);
  Eigen::Vector2d low(camera.width, camera.height);
  Eigen::Vector2d high(0, 0);
  for (const auto& position : positions) {
    if (!position) continue;
    low = low.cwiseMin(camera.project(*position));
    high = high.cwiseMax(camera.project(*position));
  }
  ingest::DetectedJoints joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double fate = random.uniform();
    const Eigen::Vector2d jitter{random.normal(), random.normal()};
    const Eigen::Vector2d anywhere{random.uniform_double(), random.uniform_double()};
    const double score = 0.6 + 0.35 * random.uniform();
    if (!positions[i] || fate < errors.misses) continue;
    const Eigen::Vector2d pixel = camera.project(*positions[i]);
    const int u = static_cast<int>(std::lround(pixel.x()));
    const int v = static_cast<int>(std::lround(pixel.y()));
    if (!depth.contains(u, v)) continue;
    const bool hidden = depth.at(u, v) > 0 && depth.at(u, v) < positions[i]->z() - kInside;
    if (fate < errors.misses + errors.outliers) {
      joints[i] = {low + anywhere.cwiseProduct(high - low), score};
    } else if (!hidden) {
      joints[i] = {pixel + errors.noise * jitter, score};
    } else if (errors.knows_hidden) {
      joints[i] = {pixel + 3 * errors.noise * jitter, 0.5 * score};
    }
  }
  if (random.uniform() < errors.swaps) {
    for (std::size_t left = 1; left < joints.size(); left += 2) std::swap(joints[left], joints[left + 1]);
  }
  return joints;
}

} // namespace kinora::tracking::testing
