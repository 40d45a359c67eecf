#include "rgbd_folder/trajectory.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"

namespace kinora::formats {
namespace {

using test::TemporaryFolder;

TEST(Trajectory, QuaternionsAreReadWithTheScalarLast) {
  const TemporaryFolder folder;
  folder.write("poses.txt", "# t x y z qx qy qz qw\n1.0 1 2 3 0 0 0.70710678 0.70710678\n");
  std::vector<std::string> warnings;
  const auto pose = Trajectory::read(folder.path() / "poses.txt", warnings).at(1.0, 0.02);
  ASSERT_TRUE(pose);
  EXPECT_TRUE((*pose * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3, 3), 1e-6));
  EXPECT_TRUE(warnings.empty());
}

TEST(Trajectory, PosesCloseInTimeAreInterpolatedAndGapsAreNot) {
  const TemporaryFolder folder;
  folder.write("poses.txt", "1.00 0 0 0 0 0 0 1\n1.05 1 0 0 0 0 0 1\n3.00 5 0 0 0 0 0 1\n");
  std::vector<std::string> warnings;
  const Trajectory trajectory = Trajectory::read(folder.path() / "poses.txt", warnings);
  EXPECT_NEAR(trajectory.at(1.025, 0.02)->translation().x(), 0.5, 1e-9);
  EXPECT_NEAR(trajectory.at(1.06, 0.02)->translation().x(), 1, 1e-9);
  EXPECT_NEAR(trajectory.at(2.99, 0.02)->translation().x(), 5, 1e-9);
  EXPECT_FALSE(trajectory.at(2.0, 0.02));
  EXPECT_FALSE(trajectory.at(0.97, 0.02));
  EXPECT_NEAR(trajectory.at(3.015, 0.02)->translation().x(), 5, 1e-9);
  EXPECT_FALSE(trajectory.at(3.03, 0.02));
}

TEST(Trajectory, LinesThatAreNoPoseAreCountedInOneWarning) {
  const TemporaryFolder folder;
  folder.write("poses.txt", "1 nan 0 0 0 0 0 1\n2 0 0 0 0 0 0 0\n3 0 0 0\nfour\n5 1 0 0 0 0 0 1\n");
  std::vector<std::string> warnings;
  const Trajectory trajectory = Trajectory::read(folder.path() / "poses.txt", warnings);
  EXPECT_TRUE(trajectory.at(5, 0.02));
  EXPECT_FALSE(trajectory.at(1, 0.02));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("4 lines"), std::string::npos);
}

TEST(PoseFile, ExponentsOfThreeDigitsAndWindowsLineEndsAreRead) {
  const TemporaryFolder folder;
  folder.write("pose.txt", " 1.0e+000\t 0\t 0\t 7.0e-001\t\r\n 0\t 1\t 0\t -2\r\n 0 0 1 3\r\n 0 0 0 1\r\n");
  EXPECT_TRUE(read_pose_file(folder.path() / "pose.txt").translation().isApprox(Eigen::Vector3d(0.7, -2, 3)));
}

TEST(PoseFile, MatricesThatAreNoPoseAreRefusedByName) {
  const TemporaryFolder folder;
  const std::string bad[] = {"",
                             "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0",
                             "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0",
                             "-inf -inf -inf -inf -inf -inf -inf -inf -inf -inf -inf -inf -inf -inf -inf -inf",
                             "1 0 0 nan 0 1 0 0 0 0 1 0 0 0 0 1",
                             "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1",
                             "1 0 0 0 0 1 0 0 0 0 -1 0 0 0 0 1",
                             "1 0 0 x 0 1 0 0 0 0 1 0 0 0 0 1"};
  for (const std::string& text : bad) {
    folder.write("pose.txt", text);
    try {
      read_pose_file(folder.path() / "pose.txt");
      ADD_FAILURE() << "accepted: " << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_NE(std::string(error.what()).find("pose.txt"), std::string::npos);
    }
  }
}

} // namespace
} // namespace kinora::formats
