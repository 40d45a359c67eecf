#include "evaluate/ground_truth_comparison.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "clip/sample_clip.h"
#include "formats/sample_capture.h"

namespace kinora::evaluate {
namespace {

using test::TemporaryFolder;

constexpr std::size_t kFrames = 6;

SE3 true_motion(std::size_t frame) {
  SE3 pose = SE3::Identity();
  pose.translate(Eigen::Vector3d(0.05 * static_cast<double>(frame), 0.1, 1.5));
  pose.rotate(Eigen::AngleAxisd(0.1 * static_cast<double>(frame), Eigen::Vector3d::UnitY()));
  return pose;
}

/// A clip whose object moves as the truth does, `error` apart from the second frame on.
player::Player player_with(const TemporaryFolder& folder, const SE3& error) {
  std::string lines;
  std::vector<motion::Motion::Pose> poses;
  const SE3 canonical_from_object = true_motion(0).inverse();
  for (std::size_t i = 0; i < kFrames; ++i) {
    const SE3 pose = true_motion(i);
    lines += std::to_string(10 + i) + " 0.0";
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) lines += fmt::format(" {:.9f}", pose(r, c));
    }
    lines += "\n";
    poses.push_back({(i == 0 ? SE3::Identity() : error) * pose * canonical_from_object});
  }
  folder.write("gt/object_pose.txt", lines);
  clip::Clip clip = clip::testing::sample_clip(1, kFrames, false);
  clip.camera_to_world = {SE3::Identity()};
  for (std::size_t i = 0; i < kFrames; ++i) clip.capture_frames[i] = static_cast<int>(10 + i);
  clip.layers[1].motion = motion::Motion::rigid(std::move(poses));
  return player::Player(std::move(clip));
}

nlohmann::json pose_report(const SE3& error) {
  const TemporaryFolder folder;
  const player::Player player = player_with(folder, error);
  const auto truth = GroundTruth::read(folder.path());
  Progress progress;
  return compare_with_ground_truth(player, truth.value(), progress).at("object_pose");
}

TEST(ObjectPose, TrueMotionHasNoError) {
  const auto report = pose_report(SE3::Identity());
  EXPECT_EQ(report.at("frames"), kFrames - 1);
  EXPECT_NEAR(report.at("error_m_mean").get<double>(), 0, 1e-5);
  EXPECT_NEAR(report.at("error_degrees_mean").get<double>(), 0, 1e-3);
}

TEST(ObjectPose, AConstantShiftIsFoundInMetres) {
  SE3 shift = SE3::Identity();
  shift.translation() = Eigen::Vector3d(0.003, 0, 0.004);
  const auto report = pose_report(shift);
  EXPECT_NEAR(report.at("error_m_mean").get<double>(), 0.005, 2e-5);
  EXPECT_NEAR(report.at("error_m_max").get<double>(), 0.005, 2e-5);
}

TEST(ObjectPose, AConstantTurnIsFoundInDegrees) {
  const SE3 rotation(Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 1, 0).normalized()));
  EXPECT_NEAR(pose_report(rotation).at("error_degrees_mean").get<double>(), 2.8648, 1e-3);
}

} // namespace
} // namespace kinora::evaluate
