#include "tracking/body/limb_poses.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tracking/body/body_prior.h"

namespace kinora::tracking::testing {
namespace {

using Vec = Eigen::Vector3d;

Eigen::Quaterniond quaternion_of(const Vec& vector) {
  return Eigen::Quaterniond(
      Eigen::AngleAxisd(vector.norm(), vector.norm() > 0 ? Vec(vector.normalized()) : Vec::UnitX()));
}

} // namespace

void rotate_root(BodyState& state, double degrees) {
  state.pose.root.linear() =
      Eigen::AngleAxisd(degrees * std::numbers::pi / 180, -Vec::UnitY()) * state.pose.root.linear();
}

LimbPose pose_of(Limb limb, const Angles& angles) {
  const LimbChain& chain = chain_of(limb);
  return {quaternion_of(angles.segment<3>(joints()[chain.ball].first_angle)),
          angles[joints()[chain.hinge].first_angle]};
}

LimbPose reaching(Limb arm, const BodyState& state, const Vec& position) {
  constexpr int kSwivels = 36;
  const PosedBody body = pose_body(state.pose, state.shape);
  Angles best = state.pose.angles;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kSwivels; ++i) {
    const Angles tried = inverse_kinematics(arm, state.pose.angles, body, body.bones[kChest] * position,
                                            2 * std::numbers::pi * i / kSwivels, 0);
    const double energy = angle_energy(tried, PosePriorConfig());
    if (energy < least) {
      least = energy;
      best = tried;
    }
  }
  return pose_of(arm, best);
}

void set_limb(Limb limb, const LimbPose& from, const LimbPose& to, double share, BodyState& state) {
  const LimbChain& chain = chain_of(limb);
  const Eigen::AngleAxisd ball(from.ball.slerp(share, to.ball));
  state.pose.angles.segment<3>(joints()[chain.ball].first_angle) = ball.angle() * ball.axis();
  state.pose.angles[joints()[chain.hinge].first_angle] = from.hinge + share * (to.hinge - from.hinge);
}

double eased(double frame, double begin, double length) {
  const double x = std::clamp((frame - begin) / length, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

double stroke(double frame, double begin, double length, double rest) {
  return eased(frame, begin, length) - eased(frame, begin + length + rest, length);
}

} // namespace kinora::tracking::testing
