#include "clip/payloads/pose_codec.h"

#include <algorithm>
#include <random>

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
  for (const double metres : {1999.9999999, 2000.0000001, 2000.5, 123456.789}) {
    SE3 far = SE3::Identity();
    far.translation() = Eigen::Vector3d(-metres, 0.1, metres / 3);
    poses.push_back(far);
  }
  Random random(1);
  for (int i = 0; i < 3000; ++i) poses.push_back(testing::random_pose(random));
  return poses;
}

Bytes bytes_of(const std::vector<int>& values) {
  Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

TEST(PoseCodec, StaysWithinHalfAMicrometreAndHalfAMicroradian) {
  for (const SE3& pose : hard_poses()) {
    const Bytes payload = encode_pose({pose, Health::kHeld});
    EXPECT_EQ(payload.size(), pose.translation().cwiseAbs().maxCoeff() > 2000.0000005 ? 40U : 23U);
    const Motion::Pose back = decode_pose(payload, "a.mkv");
    EXPECT_LE((back.canonical_to_world.translation() - pose.translation()).cwiseAbs().maxCoeff(), 0.5e-6 + 1e-12);
    EXPECT_LE(rotation_angle(back.canonical_to_world.inverse() * pose), 5e-7);
    EXPECT_EQ(back.health, Health::kHeld);
  }
}

TEST(PoseCodec, ReadsTheFortyBytesOfVersionOne) {
  const Bytes payload = bytes_of(
      {1, 2,    3,    0,    0, 0, 0, 0x10, 0,    0,    0,    0xF0, 0,    0,    0,    0xF0, // ¼ −¼ −¼, z left out
       1, 0,    0,    0,    0, 0, 0, 0,    0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,
       0, 0xE4, 0x0B, 0x54, 2, 0, 0, 0}); // 10¹⁰ µm
  const Motion::Pose pose = decode_pose(payload, "a.mkv");
  EXPECT_EQ(pose.health, Health::kLost);
  EXPECT_LE((pose.canonical_to_world.translation() - Eigen::Vector3d(1e-6, -1e-6, 1e4)).norm(), 1e-9);
  const Eigen::Matrix3d rotation = Eigen::Quaterniond(0.25, -0.25, -0.25, std::sqrt(0.8125)).toRotationMatrix();
  EXPECT_LE((pose.canonical_to_world.linear() - rotation).norm(), 1e-12);
  EXPECT_EQ(encode_pose(pose), payload); // too far for version 2
}

TEST(PoseCodec, EncodesWhatItDecodedToTheSameBytes) {
  for (const SE3& pose : hard_poses()) {
    const Bytes payload = encode_pose({pose, Health::kTracked});
    EXPECT_EQ(encode_pose(decode_pose(payload, "a.mkv")), payload);
  }
}

TEST(PoseCodec, EncodesWhatItDecodedToTheSameBytesWhereComponentsAreNearlyEqual) {
  std::mt19937 generator(29);
  std::uniform_real_distribution<double> smallest(0, 0.5);
  for (const double distance : {1.0, 5000.0}) {
    for (int i = 0; i < 200000; ++i) {
      const double small = smallest(generator);
      const double third = std::sqrt((1 - small * small) / 3);
      std::normal_distribution<double> noise(0, distance > 2000 ? 4e-9 : 5e-7); // steps of version 1, of version 2
      std::array<double, 4> q{small, third + noise(generator), third + noise(generator), third + noise(generator)};
      std::ranges::shuffle(q, generator);
      SE3 pose = SE3::Identity();
      pose.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
      pose.translation().x() = distance;
      const Bytes payload = encode_pose({pose, Health::kTracked});
      ASSERT_EQ(encode_pose(decode_pose(payload, "a.mkv")), payload) << i;
    }
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
  SE3 far = SE3::Identity();
  far.translation().x() = 5000;
  const auto expect_corrupt = [](Bytes bad, std::size_t at, int value) {
    bad[at] = static_cast<std::byte>(value);
    EXPECT_THROW(decode_pose(bad, "a.mkv"), Error) << "byte " << at;
  };
  const Bytes near = encode_pose({SE3::Identity(), Health::kTracked});
  expect_corrupt(near, 0, 1); // the other version
  expect_corrupt(near, 0, 3);
  expect_corrupt(near, 1, 3);    // health
  expect_corrupt(near, 1, 16);   // omitted component
  expect_corrupt(near, 4, 0x7F); // a component larger than the omitted one
  expect_corrupt(near, 4, 0x80);
  EXPECT_THROW(decode_pose(std::span(near).first(22), "a.mkv"), Error);
  const Bytes good = encode_pose({far, Health::kTracked});
  expect_corrupt(good, 0, 2);    // the other version
  expect_corrupt(good, 1, 3);    // health
  expect_corrupt(good, 2, 4);    // omitted component
  expect_corrupt(good, 7, 0x7F); // a component larger than the omitted one
  expect_corrupt(good, 7, 0x80);
  expect_corrupt(good, 23, 0x7F); // a translation of many light years
  expect_corrupt(good, 23, 0x80);
  EXPECT_THROW(decode_pose(std::span(good).first(39), "a.mkv"), Error);
  EXPECT_THROW(decode_pose({}, "a.mkv"), Error);
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
