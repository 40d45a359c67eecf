#include "clip/payloads/pose_codec.h"

#include <gtest/gtest.h>

#include "clip/sample_clip.h"
#include "core/error.h"

namespace kinora::clip {
namespace {

using motion::Health;
using motion::Motion;

std::vector<SE3> hard_poses() {
  std::vector<SE3> poses{SE3::Identity()};
  const double pi = std::acos(-1.0);
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 1, 1),
        Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(-1, 1, 1e-9)}) {
    // Half and third turns make components of the quaternion equal in size.
    for (const double angle : {pi, -pi, pi / 2, 2 * pi / 3, pi - 1e-9, 1e-9, 2 * std::acos(0.5)}) {
      SE3 pose = SE3::Identity();
      pose.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
      pose.translation() = axis * 123.4567891;
      poses.push_back(pose);
    }
  }
  Random random(1);
  for (int i = 0; i < 3000; ++i) poses.push_back(testing::random_pose(random));
  return poses;
}

TEST(PoseCodec, StaysWithinHalfAMicrometreAndAFewNanoradians) {
  for (const SE3& pose : hard_poses()) {
    const Motion::Pose back = decode_pose(encode_pose({pose, Health::kHeld}), "a.mkv");
    EXPECT_LE((back.canonical_to_world.translation() - pose.translation()).cwiseAbs().maxCoeff(), 0.5e-6 + 1e-12);
    EXPECT_LE((back.canonical_to_world.linear() - pose.linear()).norm(), 8e-9);
    EXPECT_EQ(back.health, Health::kHeld);
  }
}

TEST(PoseCodec, EncodesWhatItDecodedToTheSameBytes) {
  for (const SE3& pose : hard_poses()) {
    const Bytes payload = encode_pose({pose, Health::kTracked});
    EXPECT_EQ(encode_pose(decode_pose(payload, "a.mkv")), payload);
  }
}

TEST(PoseCodec, GivesRotationsThatAreRigid) {
  for (const SE3& pose : hard_poses()) {
    const Eigen::Matrix3d r = decode_pose(encode_pose({pose, Health::kLost}), "a.mkv").canonical_to_world.linear();
    EXPECT_LE((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GT(r.determinant(), 0);
  }
}

TEST(PoseCodec, RejectsEveryPayloadOutsideItsLimits) {
  const Bytes good = encode_pose({SE3::Identity(), Health::kTracked});
  const auto expect_corrupt = [&good](std::size_t at, int value) {
    Bytes bad = good;
    bad[at] = static_cast<std::byte>(value);
    EXPECT_THROW(decode_pose(bad, "a.mkv"), Error) << "byte " << at;
  };
  expect_corrupt(0, 2);    // version
  expect_corrupt(1, 3);    // health
  expect_corrupt(2, 4);    // omitted component
  expect_corrupt(7, 0x7F); // a component larger than the omitted one
  expect_corrupt(7, 0x80);
  expect_corrupt(23, 0x7F); // a translation of many light years
  expect_corrupt(23, 0x80);
  EXPECT_THROW(decode_pose({}, "a.mkv"), Error);
  EXPECT_THROW(decode_pose(std::span(good).first(39), "a.mkv"), Error);
}

TEST(PoseCodec, RefusesToStoreWhatIsNotFinite) {
  SE3 pose = SE3::Identity();
  pose.translation().x() = std::nan("");
  EXPECT_THROW(encode_pose({pose, Health::kTracked}), Error);
  pose.translation().x() = 1e12;
  EXPECT_THROW(encode_pose({pose, Health::kTracked}), Error);
}

} // namespace
} // namespace kinora::clip
