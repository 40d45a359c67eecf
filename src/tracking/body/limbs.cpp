#include "tracking/body/limbs.h"

#include <algorithm>
#include <cmath>

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

std::array<LimbChain, kLimbs> build_chains() {
  std::array<LimbChain, kLimbs> chains = {{
      {kLeftShoulder, kLeftElbow, kLeftWrist, Vec::UnitX(), {}},
      {kRightShoulder, kRightElbow, kRightWrist, -Vec::UnitX(), {}},
      {kLeftHip, kLeftKnee, kLeftAnkle, -Vec::UnitY(), {}},
      {kRightHip, kRightKnee, kRightAnkle, -Vec::UnitY(), {}},
  }};
  for (LimbChain& chain : chains) {
    for (std::size_t i = 0; i < kBodyParts; ++i) {
      const Joint bone = body_parts()[i].bone;
      if (bone == chain.ball || bone == chain.hinge || bone == chain.end) chain.parts.push_back(i);
    }
  }
  return chains;
}

} // namespace

const LimbChain& chain_of(Limb limb) {
  static const std::array<LimbChain, kLimbs> chains = build_chains();
  return chains[limb];
}

LimbLengths lengths_of(const LimbChain& chain, const PosedBody& body) {
  const PartShape& last = body.parts[chain.parts.back()];
  return {(body.bones[chain.hinge].translation() - body.bones[chain.ball].translation()).norm(),
          (body.bones[chain.end].translation() - body.bones[chain.hinge].translation()).norm(), last.b.norm()};
}

std::optional<Limb> limb_of(Joint bone) {
  for (const Limb limb : kEveryLimb) {
    const LimbChain& chain = chain_of(limb);
    if (bone == chain.ball || bone == chain.hinge || bone == chain.end) return limb;
  }
  return std::nullopt;
}

Angles inverse_kinematics(Limb limb, const Angles& angles, const PosedBody& body, const Vec& target, double swivel,
                          double beyond) {
  const LimbChain& chain = chain_of(limb);
  const LimbLengths lengths = lengths_of(chain, body);
  const double lower = lengths.lower + beyond;
  const Vec to_target = target - body.bones[chain.ball].translation();
  const Vec line = to_target.norm() > 1e-6 ? Vec(to_target.normalized()) : Vec(Vec::UnitX());
  const double distance =
      std::clamp(to_target.norm(), 1.01 * std::abs(lengths.upper - lower) + 1e-3, 0.999 * (lengths.upper + lower));
  // Law of cosines: angle at the ball joint between the line and the upper bone, and the bend of the hinge.
  const double at_ball = std::acos(
      std::clamp((lengths.upper * lengths.upper + distance * distance - lower * lower) / (2 * lengths.upper * distance),
                 -1.0, 1.0));
  const double hinge_angle = std::acos(std::clamp(
      (distance * distance - lengths.upper * lengths.upper - lower * lower) / (2 * lengths.upper * lower), -1.0, 1.0));
  const Vec across = line.unitOrthogonal();
  const Vec side = std::cos(swivel) * across + std::sin(swivel) * line.cross(across);
  const Vec upper = std::cos(at_ball) * line + std::sin(at_ball) * side;
  const Vec inward = (line - line.dot(upper) * upper).normalized(); // where bending takes the lower bone
  // In the bone's own space the lower bone bends from `axis` towards hinge × axis.
  const Vec hinge_direction = joints()[chain.hinge].axes[0].cross(chain.axis);
  Eigen::Matrix3d bone_frame;
  bone_frame << chain.axis, hinge_direction, chain.axis.cross(hinge_direction);
  Eigen::Matrix3d wanted;
  wanted << upper, inward, upper.cross(inward);
  const auto parent = static_cast<std::size_t>(joints()[chain.ball].parent);
  const Eigen::AngleAxisd rotation(
      Eigen::Matrix3d(body.bones[parent].linear().transpose() * wanted * bone_frame.transpose()));
  Angles result = angles;
  result.segment<3>(joints()[chain.ball].first_angle) = rotation.angle() * rotation.axis();
  result[joints()[chain.hinge].first_angle] = hinge_angle;
  result.segment(joints()[chain.end].first_angle, joints()[chain.end].angle_count).setZero();
  return result;
}

} // namespace kinora::tracking
