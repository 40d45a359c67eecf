#include "tracking/body/skeleton.h"

#include <cmath>
#include <numbers>

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

Vec mirrored(const Vec& offset) { return {-offset.x(), offset.y(), offset.z()}; }

// A rotation vector seen in a mirror keeps its part about the axis across, and turns the others round.
Vec mirrored_angles(const Vec& angles) { return {angles.x(), -angles.y(), -angles.z()}; }

class Builder {
public:
  void add(Joint joint, std::string_view name, int parent, const Vec& offset, Measure length, const JointInfo& motion) {
    JointInfo info = motion;
    info.name = name;
    info.parent = parent;
    info.offset = offset;
    info.length = length;
    info.first_angle = next_angle_;
    next_angle_ += info.angle_count;
    joints_[joint] = info;
  }

  // The joint on the left, and its mirror image four or three joints on.
  void add_pair(Joint left, Joint right, std::string_view left_name, std::string_view right_name, int left_parent,
                int right_parent, const Vec& offset, Measure length, const JointInfo& motion) {
    add(left, left_name, left_parent, offset, length, motion);
    JointInfo other = motion;
    if (motion.angle_count == 3) {
      const Vec a = mirrored_angles(motion.lower);
      const Vec b = mirrored_angles(motion.upper);
      other.lower = a.cwiseMin(b);
      other.upper = a.cwiseMax(b);
      other.usual = mirrored_angles(motion.usual);
    } else {
      for (Vec& axis : other.axes) axis = mirrored_angles(axis);
    }
    add(right, right_name, right_parent, mirrored(offset), length, other);
  }

  std::array<JointInfo, kJoints> take() const { return joints_; }

private:
  std::array<JointInfo, kJoints> joints_{};
  int next_angle_ = 0;
};

JointInfo ball(const Vec& lower, const Vec& upper, const Vec& usual, const Vec& sigma) {
  JointInfo joint;
  joint.angle_count = 3;
  joint.lower = lower;
  joint.upper = upper;
  joint.usual = usual;
  joint.sigma = sigma;
  return joint;
}

struct Hinge {
  Vec axis;
  double lower, upper, usual, sigma;
};

JointInfo hinges(std::initializer_list<Hinge> chain) {
  JointInfo joint;
  for (const Hinge& hinge : chain) {
    const int i = joint.angle_count++;
    joint.axes[static_cast<std::size_t>(i)] = hinge.axis;
    joint.lower[i] = hinge.lower;
    joint.upper[i] = hinge.upper;
    joint.usual[i] = hinge.usual;
    joint.sigma[i] = hinge.sigma;
  }
  return joint;
}

std::array<JointInfo, kJoints> build() {
  const Vec x = Vec::UnitX();
  const Vec y = Vec::UnitY();
  const Vec z = Vec::UnitZ();
  Builder b;
  b.add(kPelvis, "pelvis", -1, Vec::Zero(), kHeight, {});
  const JointInfo back = ball({-0.5, -0.5, -0.4}, {0.8, 0.5, 0.4}, {0.03, 0, 0}, {0.20, 0.15, 0.12});
  b.add(kSpine, "spine", kPelvis, {0, 0.076, -0.014}, kTrunkLength, back);
  b.add(kChest, "chest", kSpine, {0, 0.057, -0.008}, kTrunkLength, back);
  const JointInfo neck = ball({-0.6, -0.7, -0.5}, {0.7, 0.7, 0.5}, {0.1, 0, 0}, {0.22, 0.25, 0.15});
  b.add(kNeck, "neck", kChest, {0, 0.187, 0.012}, kTrunkLength, neck);
  b.add(kHead, "head", kNeck, {0, 0.058, 0.012}, kNeckLength, neck);
  b.add_pair(kLeftClavicle, kRightClavicle, "left_clavicle", "right_clavicle", kChest, kChest, {0.015, 0.146, 0.018},
             kTrunkLength, hinges({{z, -0.2, 0.6, 0.05, 0.12}, {y, -0.5, 0.3, 0, 0.12}}));
  b.add_pair(kLeftShoulder, kRightShoulder, "left_shoulder", "right_shoulder", kLeftClavicle, kRightClavicle,
             {0.092, -0.024, 0}, kShoulderWidth,
             ball({-1.7, -2.3, -1.75}, {1.7, 0.9, 1.75}, {0, -0.2, -1.2}, {0.6, 0.5, 0.6}));
  b.add_pair(kLeftElbow, kRightElbow, "left_elbow", "right_elbow", kLeftShoulder, kRightShoulder, {0.162, 0, 0},
             kUpperArmLength, hinges({{-y, 0, 2.6, 0.5, 0.6}}));
  b.add_pair(kLeftWrist, kRightWrist, "left_wrist", "right_wrist", kLeftElbow, kRightElbow, {0.146, 0, 0},
             kForearmLength, hinges({{z, -1.2, 1.2, 0, 0.3}, {y, -1.2, 1.2, 0, 0.3}}));
  b.add_pair(kLeftHip, kRightHip, "left_hip", "right_hip", kPelvis, kPelvis, {0.055, -0.002, 0}, kHipWidth,
             ball({-2.2, -0.8, -0.5}, {0.6, 0.8, 1.1}, {-0.1, 0, 0.05}, {0.4, 0.25, 0.2}));
  b.add_pair(kLeftKnee, kRightKnee, "left_knee", "right_knee", kLeftHip, kRightHip, {0, -0.245, 0.005}, kThighLength,
             hinges({{x, 0, 2.6, 0.15, 0.4}}));
  b.add_pair(kLeftAnkle, kRightAnkle, "left_ankle", "right_ankle", kLeftKnee, kRightKnee, {0, -0.243, -0.010},
             kShankLength, hinges({{x, -0.6, 0.9, 0, 0.2}, {y, -0.5, 0.5, 0.1, 0.15}}));
  return b.take();
}

Eigen::Matrix3d rotation_of(const Vec& vector) {
  const double angle = vector.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
}

// d rotation = skew(L · d vector) · rotation.
Eigen::Matrix3d left_jacobian(const Vec& vector) {
  const double angle = vector.norm();
  const Eigen::Matrix3d s = skew(vector);
  const double square = angle * angle;
  const double a = angle < 1e-4 ? 0.5 - square / 24 : (1 - std::cos(angle)) / square;
  const double b = angle < 1e-4 ? 1.0 / 6 - square / 120 : (angle - std::sin(angle)) / (square * angle);
  return Eigen::Matrix3d::Identity() + a * s + b * s * s;
}

Eigen::Matrix3d joint_rotation(const JointInfo& joint, const Angles& angles) {
  if (joint.angle_count == 3) return rotation_of(angles.segment<3>(joint.first_angle));
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  for (int i = 0; i < joint.angle_count; ++i) {
    rotation = rotation * rotation_of(angles[joint.first_angle + i] * joint.axes[static_cast<std::size_t>(i)]);
  }
  return rotation;
}

// Columns: the axes that the joint's angles turn about, in the parent's space.
Eigen::Matrix3d joint_axes(const JointInfo& joint, const Angles& angles) {
  if (joint.angle_count == 3) return left_jacobian(angles.segment<3>(joint.first_angle));
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d before = Eigen::Matrix3d::Identity();
  for (int i = 0; i < joint.angle_count; ++i) {
    const Vec& axis = joint.axes[static_cast<std::size_t>(i)];
    axes.col(i) = before * axis;
    before = before * rotation_of(angles[joint.first_angle + i] * axis);
  }
  return axes;
}

Vec sized_offset(const JointInfo& joint, const Shape& shape) {
  return kMeanHeight * std::exp(shape[kHeight] + (joint.length == kHeight ? 0.0 : shape[joint.length])) * joint.offset;
}

} // namespace

const std::array<JointInfo, kJoints>& joints() {
  static const std::array<JointInfo, kJoints> table = build();
  return table;
}

BodyPose rest_pose() {
  BodyPose pose;
  for (const JointInfo& joint : joints()) {
    pose.angles.segment(joint.first_angle, joint.angle_count) = joint.usual.head(joint.angle_count);
  }
  return pose;
}

BodyPose moved(const BodyPose& pose, const PoseStep& step) {
  BodyPose result;
  result.root.translation() = pose.root.translation() + step.head<3>();
  // Many small steps must not let the rotation part drift away from a rotation.
  result.root.linear() =
      Eigen::Quaterniond(rotation_of(step.segment<3>(3)) * pose.root.linear()).normalized().toRotationMatrix();
  result.angles = pose.angles + step.tail<kAngles>();
  return result;
}

PoseStep step_between(const BodyPose& from, const BodyPose& to) {
  PoseStep step;
  step.head<3>() = to.root.translation() - from.root.translation();
  const Eigen::AngleAxisd rotation(Eigen::Matrix3d(to.root.linear() * from.root.linear().transpose()));
  step.segment<3>(3) = rotation.angle() * rotation.axis();
  step.tail<kAngles>() = to.angles - from.angles;
  return step;
}

Bones forward_kinematics(const BodyPose& pose, const Shape& shape) {
  Bones bones;
  bones[kPelvis] = pose.root;
  for (std::size_t j = 1; j < kJoints; ++j) {
    const JointInfo& joint = joints()[j];
    const SE3& parent = bones[static_cast<std::size_t>(joint.parent)];
    bones[j].translation() = parent * sized_offset(joint, shape);
    bones[j].linear() = parent.linear() * joint_rotation(joint, pose.angles);
    bones[j].makeAffine();
  }
  return bones;
}

void find_bone_twists(const BodyPose& pose, const Shape& shape, const Bones& bones, BoneTwists& twists) {
  const Vec origin = pose.root.translation();
  twists[kPelvis].setZero();
  twists[kPelvis].block<3, 3>(0, 0).setIdentity();
  twists[kPelvis].block<3, 3>(0, 3) = skew(origin); // ω × (0 − origin)
  twists[kPelvis].block<3, 3>(3, 3).setIdentity();
  for (std::size_t j = 1; j < kJoints; ++j) {
    const JointInfo& joint = joints()[j];
    const auto parent = static_cast<std::size_t>(joint.parent);
    auto& twist = twists[j];
    twist = twists[parent];
    const Vec offset = bones[parent].linear() * sized_offset(joint, shape);
    twist.block<3, 1>(0, kPoseDof + kHeight) += offset;
    if (joint.length != kHeight) twist.block<3, 1>(0, kPoseDof + joint.length) += offset;
    const Eigen::Matrix3d axes = bones[parent].linear() * joint_axes(joint, pose.angles);
    for (int i = 0; i < joint.angle_count; ++i) {
      twist.block<3, 1>(0, 6 + joint.first_angle + i) = bones[j].translation().cross(axes.col(i));
      twist.block<3, 1>(3, 6 + joint.first_angle + i) = axes.col(i);
    }
  }
}

} // namespace kinora::tracking
