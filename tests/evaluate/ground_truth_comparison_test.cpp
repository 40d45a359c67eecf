#include "evaluate/ground_truth_comparison.h"

#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "clip/sample_clip.h"
#include "core/image_codec.h"
#include "fields/scenes/painted_field.h"
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

/// A red ball 1.2 m before the world's origin that goes 15 cm to the right with each frame of the clip.
player::Player ball_that_goes_right() {
  clip::Clip clip = clip::testing::sample_clip(1, 3, false);
  clip.camera_to_world = {SE3::Identity()};
  clip.capture_frames = {0, 1, 2};
  clip.layers.resize(1);
  clip.layers[0].label = 1;
  clip.layers[0].field =
      fields::testing::painted_field({{-0.5, -0.5, 0.7}, 1}, fields::testing::PaintedBall{{0, 0, 1.2}});
  clip.layers[0].confidence.reset();
  std::vector<motion::Motion::Pose> poses;
  poses.reserve(3);
  for (int i = 0; i < 3; ++i) poses.push_back({SE3(Eigen::Translation3d(0.15 * i, 0, 0)), motion::Health::kTracked});
  clip.layers[0].motion = motion::Motion::rigid(std::move(poses));
  return player::Player(std::move(clip));
}

/// What the player itself shows a camera 20 cm to the right at frame 2 is the truth of that camera.
nlohmann::json novel_report(const player::Player& player, double camera_x) {
  const TemporaryFolder folder;
  folder.write("cameras.json", fmt::format(R"({{"cameras": [
    {{"name": "capture", "width": 48, "height": 36, "fx": 40, "fy": 40, "cx": 23.5, "cy": 17.5,
      "camera_to_world": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}},
    {{"name": "side", "width": 48, "height": 36, "fx": 40, "fy": 40, "cx": 23.5, "cy": 17.5,
      "camera_to_world": [[1,0,0,{}],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}}]}})",
                                           camera_x));
  Camera camera{{48, 36, 40, 40, 23.5, 17.5}, SE3(Eigen::Translation3d(0.2, 0, 0))};
  const fields::Picture picture = player.draw(camera, 2, player.all_layers());
  ColorImage color(48, 36, 3);
  ColorImage mask(48, 36, 1);
  for (std::size_t i = 0; i < color.pixel_count(); ++i) {
    const double alpha = picture.color.data()[4 * i + 3] / 255.0;
    for (std::size_t c = 0; c < 3; ++c) {
      color.data()[3 * i + c] = static_cast<std::uint8_t>(std::nearbyint(alpha * picture.color.data()[4 * i + c]));
    }
    mask.data()[i] = picture.color.data()[4 * i + 3] > 127 ? 1 : 0;
  }
  folder.write("novel/side/rgb/000002.png", encode_png(color));
  folder.write("novel/side/mask/000002.png", encode_png(mask));
  const auto truth = GroundTruth::read(folder.path());
  Progress progress;
  return compare_with_ground_truth(player, truth.value(), progress).at("novel_cameras").at(0).at("layers").at(0);
}

TEST(NovelCameras, ShowWhatTheClipShowsThereAtThatFrame) {
  const player::Player player = ball_that_goes_right();
  const nlohmann::json same = novel_report(player, 0.2);
  EXPECT_EQ(same.at("frames"), 1);
  EXPECT_GT(same.at("psnr_inside").get<double>(), 40);
  EXPECT_GT(same.at("iou").get<double>(), 0.95);
  const nlohmann::json elsewhere = novel_report(player, 0.35);
  EXPECT_LT(elsewhere.at("iou").get<double>(), 0.8) << "a camera beside it sees the ball elsewhere";
}

} // namespace
} // namespace kinora::evaluate
