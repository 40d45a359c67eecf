#include "tracking/body/shape_from_mesh.h"

#include <gtest/gtest.h>

#include "tracking/body/limbs.h"
#include "tracking/body/synthetic_body.h"

namespace kinora::tracking {
namespace {

// Little triangles on the surface of our own body, and its joints, as a file would have them.
ingest::BodyMesh mesh_of(const BodyPose& pose, const Shape& shape) {
  constexpr double kSide = 0.03; // metres
  ingest::BodyMesh mesh;
  const PosedBody body = pose_body(pose, shape);
  for (const BodySample& sample : body_samples()) {
    const SE3& bone = body.bones[body_parts()[sample.part].bone];
    const Eigen::Vector3d centre = bone * position_of(body.parts[sample.part], sample.point);
    const Eigen::Vector3d normal = bone.linear() * normal_of(body.parts[sample.part], sample.point);
    const Eigen::Vector3d across = normal.unitOrthogonal();
    const Eigen::Vector3d along = normal.cross(across);
    const std::size_t first = mesh.vertices.size();
    mesh.vertices.emplace_back(centre + kSide * across);
    mesh.vertices.emplace_back(centre + kSide * (-0.5 * across + 0.87 * along));
    mesh.vertices.emplace_back(centre + kSide * (-0.5 * across - 0.87 * along));
    mesh.faces.push_back({first, first + 1, first + 2});
  }
  mesh.bone.assign(mesh.vertices.size(), 0);
  constexpr std::array<Joint, ingest::kBodyMeshJoints> kOurs = {
      kPelvis,       kLeftHip,       kRightHip,  kSpine,      kLeftKnee,  kRightKnee,    kSpine,         kLeftAnkle,
      kRightAnkle,   kChest,         kLeftAnkle, kRightAnkle, kNeck,      kLeftClavicle, kRightClavicle, kHead,
      kLeftShoulder, kRightShoulder, kLeftElbow, kRightElbow, kLeftWrist, kRightWrist};
  for (std::size_t j = 0; j < kOurs.size(); ++j) mesh.joints.at(j) = body.bones[kOurs.at(j)].translation();
  return mesh;
}

TEST(BodySizes, AreThoseOfTheMesh) {
  Shape shape = Shape::Zero();
  shape[kHeight] = 0.08;
  shape[kForearmLength] = 0.10;
  shape[kThighLength] = -0.06;
  shape[kChestGirth] = 0.15;
  shape[kThighGirth] = -0.10;
  for (const double lowered : {0.0, 0.8}) { // arms to the sides, and hanging half
    BodyPose pose;
    pose.angles[joints()[kLeftShoulder].first_angle + 2] = -lowered;
    pose.angles[joints()[kRightShoulder].first_angle + 2] = lowered;
    const BodyPrior known = measure_body(mesh_of(pose, shape));
    const Bones expected = forward_kinematics(pose, shape);
    const Bones found = forward_kinematics(known.state.pose, known.state.shape);
    for (const Joint joint : {kLeftElbow, kLeftWrist, kRightKnee, kRightAnkle, kHead}) {
      EXPECT_LT((found[joint].translation() - expected[joint].translation()).norm(), 0.025) << joints()[joint].name;
    }
    EXPECT_NEAR(known.state.shape[kChestGirth] + known.state.shape[kHeight], 0.23, 0.05);
    EXPECT_NEAR(known.state.shape[kThighGirth] + known.state.shape[kHeight], -0.02, 0.05);
  }
}

TEST(BodySizes, AreFiniteForAMeshWhoseJointsAreAllInOnePlace) {
  ingest::BodyMesh mesh = mesh_of(BodyPose(), Shape::Zero());
  mesh.joints.fill(Eigen::Vector3d::Zero());
  const BodyPrior known = measure_body(mesh);
  EXPECT_TRUE(known.state.shape.allFinite());
  EXPECT_TRUE(known.shape_precision.allFinite());
}

} // namespace
} // namespace kinora::tracking
