#include "clip/payloads/joints_codec.h"

#include <limits>

#include <gtest/gtest.h>

#include "clip/sample_clip.h"
#include "core/error.h"

namespace kinora::clip {
namespace {

using motion::JointPaths;
using testing::random_joints;

constexpr const char* kLocation = "a.mkv: byte 7";

JointPaths decode(const Bytes& payload, std::size_t frames) {
  AllocationBudget budget(payload.size());
  return decode_joints(payload, frames, kLocation, budget);
}

void expect_corrupt(const Bytes& payload, std::size_t frames) {
  try {
    decode(payload, frames);
    ADD_FAILURE() << "decoded without an error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    EXPECT_EQ(std::string(error.what()).rfind(kLocation, 0), 0U) << error.what();
  }
}

void expect_refused(const JointPaths& joints) {
  try {
    encode_joints(joints);
    ADD_FAILURE() << "encoded without an error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFailure);
  }
}

TEST(JointsCodec, GivesBackNamesAndPlacesToAMillimetre) {
  const JointPaths joints = random_joints(1, 40);
  const JointPaths stored = decode(encode_joints(joints), 40);
  EXPECT_EQ(stored.names, joints.names);
  ASSERT_EQ(stored.positions.size(), 40U);
  for (std::size_t f = 0; f < 40; ++f) {
    for (std::size_t j = 0; j < joints.names.size(); ++j) {
      EXPECT_LT((stored.positions[f][j] - joints.positions[f][j]).cwiseAbs().maxCoeff(), 0.001);
    }
  }
}

TEST(JointsCodec, WritesWhatItReadAsTheSameBytes) {
  const Bytes payload = encode_joints(random_joints(2, 30));
  EXPECT_EQ(encode_joints(decode(payload, 30)), payload);
}

TEST(JointsCodec, NeedsLittleForJointsThatMoveTogether) {
  JointPaths joints = random_joints(3, 90);
  for (std::size_t f = 1; f < 90; ++f) {
    for (std::size_t j = 0; j < joints.names.size(); ++j) {
      joints.positions[f][j] = joints.positions[f - 1][j] + Eigen::Vector3d(0.02, 0, -0.01);
    }
  }
  EXPECT_LT(encode_joints(joints).size(), 1500U); // in 3 s
}

TEST(JointsCodec, HoldsJointsAtTheEdgeOfTheRange) {
  JointPaths joints{{"left", "right"}, {}};
  const Eigen::Vector3d far(16384, -16384, 16384);
  const Eigen::Vector3d opposite = -far;
  for (int f = 0; f < 2; ++f) {
    joints.positions.push_back({far, opposite});
    joints.positions.push_back({opposite, far});
  }
  EXPECT_EQ(decode(encode_joints(joints), 4).positions, joints.positions);
}

TEST(JointsCodec, RefusesWhatIsCutOrGoesOnOrHasAnotherNumberOfFrames) {
  const Bytes payload = encode_joints(random_joints(4, 10));
  // The last bytes may be zeros that a reader would add.
  for (std::size_t size = 0; size + 8 < payload.size(); size += 5) {
    expect_corrupt(Bytes(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(size)), 10);
  }
  Bytes longer = payload;
  longer.resize(payload.size() + 9);
  expect_corrupt(longer, 10);
  expect_corrupt(payload, 5);
  expect_corrupt(payload, 20);
}

TEST(JointsCodec, RefusesOtherVersionsCountsAndNames) {
  const Bytes payload = encode_joints(random_joints(5, 10));
  for (const std::size_t byte : {0U, 1U, 2U, 3U}) { // version, joints, length of a name, its first letter
    for (const int value : {0, 255}) {
      Bytes changed = payload;
      changed[byte] = static_cast<std::byte>(value);
      expect_corrupt(changed, 10);
    }
  }
}

TEST(JointsCodec, TakesNoMoreMemoryThanItsBudget) {
  const Bytes payload = encode_joints(random_joints(6, 10));
  expect_corrupt(payload, 10'000'000);
}

TEST(JointsCodec, StoresNoImpossibleSkeleton) {
  const JointPaths joints = random_joints(7, 5);
  JointPaths changed = joints;
  changed.names[3] = "";
  expect_refused(changed);
  changed.names[3] = "Näme";
  expect_refused(changed);
  changed = joints;
  changed.positions[2].pop_back();
  expect_refused(changed);
  changed = joints;
  changed.positions[2][1].x() = std::numeric_limits<double>::quiet_NaN();
  expect_refused(changed);
  expect_refused({});
}

} // namespace
} // namespace kinora::clip
