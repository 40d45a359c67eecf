// Joints of people as a detector finds them in a picture.
// Source of the joints and their order: Lin et al., "Microsoft COCO: Common Objects in Context", ECCV 2014 (key
// points).
#pragma once

#include <array>

#include <Eigen/Core>

namespace kinora::ingest {

/// Left and right are the person's.
enum class DetectedJointName {
  kNose,
  kLeftEye,
  kRightEye,
  kLeftEar,
  kRightEar,
  kLeftShoulder,
  kRightShoulder,
  kLeftElbow,
  kRightElbow,
  kLeftWrist,
  kRightWrist,
  kLeftHip,
  kRightHip,
  kLeftKnee,
  kRightKnee,
  kLeftAnkle,
  kRightAnkle
};
constexpr std::size_t kDetectedJoints = 17;

struct DetectedJoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double score = 0; ///< in [0, 1]; 0: not found
};
using DetectedJoints = std::array<DetectedJoint, kDetectedJoints>;

/// The person that has a label.
struct DetectedPerson {
  int label = 0;
  DetectedJoints joints;
};

} // namespace kinora::ingest
