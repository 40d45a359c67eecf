// A synthetic walker: nodes on a torso and four limbs that swing, with jitter as a tracker leaves it.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "core/random.h"
#include "motion/motion.h"

namespace kinora::clip::testing {

struct WalkerOptions {
  std::size_t nodes = 450;
  std::size_t frames = 90;
  double position_jitter = 0.0003; ///< metres, standard deviation for each axis
  double rotation_jitter = 0.003;  ///< radians, the same
  std::uint64_t seed = 1;
};

inline constexpr std::size_t kLimbs = 4; // the torso comes after them

/// Legs hang from hips, arms from shoulders.
inline Eigen::Vector3d limb_hinge(std::size_t limb) {
  const double side = limb % 2 == 0 ? -1 : 1;
  return limb < 2 ? Eigen::Vector3d(0.1 * side, 0, 2) : Eigen::Vector3d(0.3 * side, -0.55, 2);
}

/// Points around vertical axes: limbs 0.7 m long, 0.06 m thick, below their hinges; a torso 0.6 m high.
inline Eigen::Vector3d walker_point(std::size_t part, Random& random) {
  const double around = 2 * std::numbers::pi * random.uniform_double();
  const double down = random.uniform_double();
  const double radius = part < kLimbs ? 0.06 : 0.15;
  const Eigen::Vector3d top = part < kLimbs ? limb_hinge(part) : Eigen::Vector3d(0, -0.6, 2.0);
  return top +
         Eigen::Vector3d(radius * std::cos(around), (part < kLimbs ? 0.7 : 0.6) * down, radius * std::sin(around));
}

inline SE3 turn_around_x(const Eigen::Vector3d& hinge, double angle) {
  return Eigen::Translation3d(hinge) * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()) *
         Eigen::Translation3d(-hinge);
}

/// Where a point of `part` is: limbs swing to and fro and bend in their middle, and all walks and turns.
inline SE3 walker_transform(std::size_t part, const Eigen::Vector3d& point, double seconds) {
  SE3 limb = SE3::Identity();
  if (part < kLimbs) {
    constexpr double kPeriod = 1.1;
    const Eigen::Vector3d hinge = limb_hinge(part);
    const Eigen::Vector3d joint = hinge + Eigen::Vector3d(0, 0.35, 0);
    const double phase = 2 * std::numbers::pi * seconds / kPeriod + (part % 3 == 0 ? 0 : std::numbers::pi);
    const double below = std::clamp((point.y() - joint.y()) / 0.16 + 0.5, 0.0, 1.0);
    const double bend = 0.4 * (1 + std::sin(phase + 1)) * below * below * (3 - 2 * below);
    limb = turn_around_x(hinge, 0.5 * std::sin(phase)) * turn_around_x(joint, bend);
  }
  const Eigen::Vector3d centre(0, 0, 2);
  return Eigen::Translation3d(centre + Eigen::Vector3d(0.9 * seconds, 0.02 * std::sin(12 * seconds), 0)) *
         Eigen::AngleAxisd(0.8 * seconds, Eigen::Vector3d::UnitY()) * Eigen::Translation3d(-centre) * limb;
}

inline SE3 walker_jitter(const WalkerOptions& options, const Eigen::Vector3d& at, Random& random) {
  Twist twist;
  for (int i = 0; i < 3; ++i) {
    twist[i] = random.normal() * options.position_jitter;
    twist[3 + i] = random.normal() * options.rotation_jitter;
  }
  return Eigen::Translation3d(at) * exp_se3(twist) * Eigen::Translation3d(-at);
}

inline motion::Motion walker(const WalkerOptions& options) {
  Random random(options.seed);
  std::vector<Eigen::Vector3d> nodes;
  const auto part_of = [](std::size_t i) { return i % (kLimbs + 1); };
  for (std::size_t i = 0; i < options.nodes; ++i) nodes.push_back(walker_point(part_of(i), random));
  std::vector<motion::Motion::Deformation> deformations;
  for (std::size_t f = 0; f < options.frames; ++f) {
    motion::Motion::Deformation deformation;
    for (std::size_t i = 0; i < options.nodes; ++i) {
      const SE3 smooth = walker_transform(part_of(i), nodes[i], static_cast<double>(f) / 30);
      deformation.node_to_world.push_back(
          DualQuaternion::from(walker_jitter(options, smooth * nodes[i], random) * smooth));
    }
    deformation.health = static_cast<motion::Health>(random.below(3));
    deformations.push_back(std::move(deformation));
  }
  auto graph = std::make_shared<const motion::DeformationGraph>(std::move(nodes), 0.05, 0.1);
  return motion::Motion::deforming(std::move(graph), std::move(deformations));
}

} // namespace kinora::clip::testing
