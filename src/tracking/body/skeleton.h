// Joints of a person: what turns about what, how far, and where that puts every bone.
// Sources: proportions after Drillis and Contini, "Body Segment Parameters", 1966, as Winter, "Biomechanics and Motor
// Control of Human Movement", 2009, fig. 4.1, gives them; derivative of a rotation vector: Sola et al.,
// arXiv:1812.01537, eq. 145.
#pragma once

#include <array>
#include <string_view>

#include "core/se3.h"

namespace kinora::tracking {

/// A parent comes before its children. Each carries the bone that starts at it.
enum Joint {
  kPelvis,
  kSpine,
  kChest,
  kNeck,
  kHead,
  kLeftClavicle,
  kLeftShoulder,
  kLeftElbow,
  kLeftWrist,
  kRightClavicle,
  kRightShoulder,
  kRightElbow,
  kRightWrist,
  kLeftHip,
  kLeftKnee,
  kLeftAnkle,
  kRightHip,
  kRightKnee,
  kRightAnkle,
  kJoints
};

/// What a body's size is made of, as logarithms of factors on mean proportions; both sides alike.
enum Measure {
  kHeight, ///< of everything; zero: kMeanHeight
  kTrunkLength,
  kNeckLength,
  kHeadLength,
  kUpperArmLength,
  kForearmLength,
  kHandLength,
  kThighLength,
  kShankLength,
  kFootLength,
  kShoulderWidth,
  kHipWidth,
  kPelvisGirth,
  kWaistGirth,
  kChestGirth,
  kTrunkWidth, ///< against its depth
  kShoulderGirth,
  kNeckGirth,
  kHeadGirth,
  kUpperArmGirth,
  kForearmGirth,
  kHandGirth,
  kThighGirth,
  kKneeGirth,
  kCalfGirth,
  kAnkleGirth,
  kFootGirth,
  kMeasures
};

constexpr double kMeanHeight = 1.70; ///< metres
constexpr int kAngles = 40;
constexpr int kPoseDof = 6 + kAngles;      ///< the pelvis moves freely
constexpr int kDof = kPoseDof + kMeasures; ///< of pose and shape together

using Shape = Eigen::Matrix<double, kMeasures, 1>;
using Angles = Eigen::Matrix<double, kAngles, 1>;
using PoseStep = Eigen::Matrix<double, kPoseDof, 1>;

/// Bones have axes x to the person's left, y up, z forward when the body stands with its arms stretched to the sides,
/// where all angles are zero. Ball joints hold a rotation vector; others turn about one or two axes in turn.
struct BodyPose {
  SE3 root = SE3::Identity(); ///< pelvis to the space around it
  Angles angles = Angles::Zero();
};

struct JointInfo {
  std::string_view name;
  int parent = -1;                                  ///< −1: none
  Eigen::Vector3d offset = Eigen::Vector3d::Zero(); ///< from the parent's joint, in its axes and in body heights
  Measure length = kHeight;                         ///< that scales the offset
  int first_angle = 0;                              ///< of the pose's angles
  int angle_count = 0;                              ///< 3: a ball joint
  std::array<Eigen::Vector3d, 2> axes = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}; ///< of all others
  Eigen::Vector3d lower = Eigen::Vector3d::Zero(); ///< limits of the angles, radians
  Eigen::Vector3d upper = Eigen::Vector3d::Zero();
  Eigen::Vector3d usual = Eigen::Vector3d::Zero(); ///< mean and standard deviation in everyday poses
  Eigen::Vector3d sigma = Eigen::Vector3d::Ones();
};

const std::array<JointInfo, kJoints>& joints();

/// The pose of somebody who stands and lets the arms hang, in the space of the pelvis.
BodyPose rest_pose();

/// Rows 0–2 of a step move the pelvis, rows 3–5 turn the body about it, the others add to the angles.
BodyPose moved(const BodyPose& pose, const PoseStep& step);
/// The step with moved(from, step) = to.
PoseStep step_between(const BodyPose& from, const BodyPose& to);

using Bones = std::array<SE3, kJoints>; ///< bone to the space around the body
Bones forward_kinematics(const BodyPose& pose, const Shape& shape);

/// How each bone moves with each freedom: twists about the origin of the space around the body (rows 0–2 velocity of
/// what is at the origin, rows 3–5 rotation). Columns: the pose's freedoms, then the measures.
using BoneTwists = std::array<Eigen::Matrix<double, 6, kDof>, kJoints>;
void find_bone_twists(const BodyPose& pose, const Shape& shape, const Bones& bones, BoneTwists& twists);

} // namespace kinora::tracking
