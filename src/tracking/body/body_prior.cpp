#include "tracking/body/body_prior.h"

#include <algorithm>

#include "tracking/body/limbs.h"
#include "tracking/body/pose_prior.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

// Spread of people's measures about mean proportions.
Shape usual_shape_precision() {
  Shape sigma;
  sigma.segment<kHipWidth - kTrunkLength + 1>(kTrunkLength).setConstant(0.035);
  sigma.tail<kMeasures - kPelvisGirth>().setConstant(0.12);
  sigma[kHeight] = 0.12;
  return sigma.cwiseAbs2().cwiseInverse();
}

// How far an angle is outside its limits.
double excess(double angle, double lower, double upper) {
  return angle < lower ? angle - lower : angle > upper ? angle - upper : 0.0;
}

template <class F> void for_each_angle(const F& visit) {
  for (const JointInfo& joint : joints()) {
    for (int i = 0; i < joint.angle_count; ++i) visit(joint.first_angle + i, joint, i);
  }
}

// The pose prior knows more of ball joints and hinges of limbs than their usual angles.
bool is_in_pose_prior(int index) {
  static const std::array<bool, kAngles> known = [] {
    std::array<bool, kAngles> result{};
    for (const Limb limb : kEveryLimb) {
      std::fill_n(result.begin() + joints()[chain_of(limb).ball].first_angle, 3, true);
      result.at(static_cast<std::size_t>(joints()[chain_of(limb).hinge].first_angle)) = true;
    }
    return result;
  }();
  return known.at(static_cast<std::size_t>(index));
}

void add_limb_prior(Limb limb, const Angles& angles, const PosePriorConfig& poses, BodyEquations& equations) {
  const PosePrior prior = pose_prior(limb, limb_angles(limb, angles), poses);
  const Eigen::Index ball = 6 + joints()[chain_of(limb).ball].first_angle;
  const Eigen::Index hinge = 6 + joints()[chain_of(limb).hinge].first_angle;
  const std::array<Eigen::Index, kLimbAngles> rows = {ball, ball + 1, ball + 2, hinge};
  for (std::size_t i = 0; i < kLimbAngles; ++i) {
    equations.gradient[rows[i]] += prior.gradient[static_cast<Eigen::Index>(i)];
    for (std::size_t j = 0; j < kLimbAngles; ++j) {
      equations.hessian(rows[i], rows[j]) += prior.hessian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
}

void add_angles(const Angles& angles, const PosePriorConfig& poses, BodyEquations& equations) {
  equations.energy += angle_energy(angles, poses);
  for (const Limb limb : kEveryLimb) add_limb_prior(limb, angles, poses, equations);
  for_each_angle([&](int index, const JointInfo& joint, int i) {
    const double usual = is_in_pose_prior(index) ? 0.0 : 1 / (joint.sigma[i] * joint.sigma[i]);
    const double beyond = excess(angles[index], joint.lower[i], joint.upper[i]);
    const double limit = 1 / (poses.limit_sigma * poses.limit_sigma);
    equations.gradient[6 + index] += usual * (angles[index] - joint.usual[i]) + limit * beyond;
    equations.hessian(6 + index, 6 + index) += usual + (beyond != 0 ? limit : 0.0);
  });
}

bool is_solid(Joint bone) {
  return bone == kPelvis || bone == kSpine || bone == kChest || bone == kLeftHip || bone == kRightHip;
}

// One of the spheres of an arm's part against the trunk and the thighs. These are seen well, and do not give way.
void find_collisions(const BodyInCamera& body, std::size_t part, double along, std::vector<ArmPenalty>& found) {
  constexpr double kSoftness = 0.01; // metres that flesh and cloth give way
  constexpr double kDeviation = 0.02;
  const PartShape& shape = body.body().parts[part];
  const double radius = shape.radius_a + along * (shape.radius_b - shape.radius_a);
  const Vec centre = body.bone(part) * (shape.a + along * (shape.b - shape.a));
  for (std::size_t solid = 0; solid < kBodyParts; ++solid) {
    if (!is_solid(body_parts()[solid].bone)) continue;
    const ClosestSurface surface = closest_surface(body.body().parts[solid], body.to_bone(solid) * centre);
    const double depth = radius - kSoftness - surface.distance;
    if (depth <= 0) continue;
    const Vec inward = -(body.bone(solid).linear() * surface.normal);
    const PartPoint deepest{along, body.bone(part).linear().transpose() * inward};
    found.push_back({part, deepest, depth / kDeviation, inward / kDeviation});
  }
}

} // namespace

double angle_energy(const Angles& angles, const PosePriorConfig& poses) {
  double energy = 0;
  for (const Limb limb : kEveryLimb) energy += pose_prior(limb, limb_angles(limb, angles), poses).energy;
  for_each_angle([&](int index, const JointInfo& joint, int i) {
    const double deviation = is_in_pose_prior(index) ? 0.0 : (angles[index] - joint.usual[i]) / joint.sigma[i];
    const double beyond = excess(angles[index], joint.lower[i], joint.upper[i]) / poses.limit_sigma;
    energy += deviation * deviation + beyond * beyond;
  });
  return energy;
}

void add_prior(const BodyState& state, const BodyPrior& prior, const PosePriorConfig& poses, BodyEquations& equations) {
  add_angles(state.pose.angles, poses, equations);
  const PoseStep step = step_between(prior.state.pose, state.pose);
  const PoseStep pose_gradient = prior.pose_precision.cwiseProduct(step);
  equations.energy += pose_gradient.dot(step);
  equations.gradient.head<kPoseDof>() += pose_gradient;
  equations.hessian.topLeftCorner<kPoseDof, kPoseDof>().diagonal() += prior.pose_precision;
  const Shape difference = state.shape - prior.state.shape;
  const Shape known_gradient = prior.shape_precision * difference;
  const Shape usual_gradient = usual_shape_precision().cwiseProduct(state.shape);
  equations.energy += known_gradient.dot(difference) + usual_gradient.dot(state.shape);
  equations.gradient.tail<kMeasures>() += known_gradient + usual_gradient;
  equations.hessian.bottomRightCorner<kMeasures, kMeasures>() += prior.shape_precision;
  equations.hessian.bottomRightCorner<kMeasures, kMeasures>().diagonal() += usual_shape_precision();
}

std::vector<ArmPenalty> arm_penalties(const BodyInCamera& body) {
  constexpr double kBehindBack = 0.15; // metres, one deviation
  const SE3& chest = body.body().bones[kChest];
  const Vec forward = chest.linear().col(2);
  std::vector<ArmPenalty> found;
  for (const Limb limb : {kLeftArm, kRightArm}) {
    const std::vector<std::size_t>& parts = chain_of(limb).parts;
    for (const std::size_t part : parts) {
      for (const double along : {0.6, 1.0}) find_collisions(body, part, along, found);
    }
    const SE3& hand = body.bone(parts.back());
    const double behind = (chest.translation() - hand.translation()).dot(forward);
    const PartPoint wrist{0, hand.linear().transpose() * forward};
    if (behind > 0) found.push_back({parts.back(), wrist, behind / kBehindBack, -forward / kBehindBack});
  }
  return found;
}

double energy_of(const std::vector<ArmPenalty>& reluctances) {
  double energy = 0;
  for (const ArmPenalty& r : reluctances) energy += r.value * r.value;
  return energy;
}

} // namespace kinora::tracking
