#include "tracking/body/joint_observations.h"

#include <algorithm>

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

std::size_t part_of(Joint bone) {
  const auto& parts = body_parts();
  const auto found = std::find_if(parts.begin(), parts.end(), [&](const BodyPart& part) { return part.bone == bone; });
  return static_cast<std::size_t>(found - parts.begin());
}

std::array<Landmark, ingest::kDetectedJoints> build_landmarks() {
  const auto of_head = [](double along, const Vec& direction) {
    return Landmark{part_of(kHead), PartPoint{along, direction.normalized()}};
  };
  const auto of_joint = [](Joint joint) { return Landmark{part_of(joint), std::nullopt}; };
  return {of_head(0.2, Vec(0, 0, 1)),
          of_head(0.9, Vec(0.35, 0, 1)),
          of_head(0.9, Vec(-0.35, 0, 1)),
          of_head(0.5, Vec(1, 0, -0.1)),
          of_head(0.5, Vec(-1, 0, -0.1)),
          of_joint(kLeftShoulder),
          of_joint(kRightShoulder),
          of_joint(kLeftElbow),
          of_joint(kRightElbow),
          of_joint(kLeftWrist),
          of_joint(kRightWrist),
          of_joint(kLeftHip),
          of_joint(kRightHip),
          of_joint(kLeftKnee),
          of_joint(kRightKnee),
          of_joint(kLeftAnkle),
          of_joint(kRightAnkle)};
}

} // namespace

std::vector<JointObservation> observe_joints(const ingest::DetectedJoints& joints, const Intrinsics& camera,
                                             const DetectedJointsConfig& config) {
  std::vector<JointObservation> observed;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (!(joints[i].score >= config.min_score) || !joints[i].pixel.allFinite()) continue;
    const double score = std::min(1.0, joints[i].score);
    const Vec ray = camera.unproject(joints[i].pixel.x(), joints[i].pixel.y(), 1);
    observed.push_back({i, ray.head<2>(), config.weight * score * score});
  }
  return observed;
}

const Landmark& landmark_of(std::size_t joint) {
  static const std::array<Landmark, ingest::kDetectedJoints> table = build_landmarks();
  return table.at(joint);
}

Vec position_of(const Landmark& landmark, const PosedBody& body) {
  const SE3& bone = body.bones[body_parts()[landmark.part].bone];
  return landmark.point ? Vec(bone * position_of(body.parts[landmark.part], *landmark.point)) : bone.translation();
}

RayDistance::RayDistance(const Vec& position, const Eigen::Vector2d& ray)
    : directions{Vec(1, 0, -ray.x()), Vec(0, 1, -ray.y())}, value(position.head<2>() - position.z() * ray) {}

double energy_of(const JointObservation& observed, const PosedBody& body, const DetectedJointsConfig& config) {
  const RayDistance distance(position_of(landmark_of(observed.joint), body), observed.ray);
  return observed.weight * robust_cost(config).cost(distance.value.squaredNorm());
}

double loss_derivative(const JointObservation& observed, double squared, const DetectedJointsConfig& config) {
  return observed.weight * robust_cost(config).weight(squared) / (config.sigma * config.sigma);
}

std::vector<JointObservation> consistent_observations(std::span<const JointObservation> observed,
                                                      std::span<const JointObservation> before,
                                                      const PosedBody& expected, const DetectedJointsConfig& config) {
  std::vector<JointObservation> result;
  for (const JointObservation& now : observed) {
    const Vec position = position_of(landmark_of(now.joint), expected);
    const bool is_near = RayDistance(position, now.ray).value.norm() < config.cutoff;
    const bool was_there = std::any_of(before.begin(), before.end(), [&](const JointObservation& then) {
      return then.joint == now.joint && position.z() * (then.ray - now.ray).norm() < config.cutoff;
    });
    if (is_near || was_there) result.push_back(now);
  }
  return result;
}

double energy_of(std::span<const JointObservation> observed, const PosedBody& body,
                 const DetectedJointsConfig& config) {
  double energy = 0;
  for (const JointObservation& joint : observed) energy += energy_of(joint, body, config);
  return energy;
}

} // namespace kinora::tracking
