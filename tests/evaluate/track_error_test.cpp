#include "evaluate/track_error.h"

#include <gtest/gtest.h>

#include "clip/sample_clip.h"

namespace kinora::evaluate {
namespace {

using Vec = Eigen::Vector3d;

constexpr std::size_t kFrames = 4;

SE3 shifted(double x, double y = 0, double z = 0) { return SE3(Eigen::Translation3d(x, y, z)); }

/// A person that goes 5 cm a frame to the right, before a camera that goes 1 m a frame upwards.
clip::Clip clip_of_walker() {
  clip::Clip clip = clip::testing::sample_clip(1, kFrames, true);
  std::vector<motion::Motion::Pose> poses;
  for (std::size_t i = 0; i < kFrames; ++i) {
    poses.push_back({shifted(0.05 * static_cast<double>(i)), motion::Health::kTracked});
    clip.camera_to_world[i] = shifted(0, static_cast<double>(i), 0);
  }
  clip.layers[1].label = 1;
  clip.layers[1].name = "anna";
  clip.layers[1].motion = motion::Motion::rigid(std::move(poses));
  return clip;
}

/// Where the camera sees a point that goes along with the person, at a frame of the clip; `off` from there.
TruePosition at(std::size_t i, bool visible, const Vec& off = Vec::Zero()) {
  return {Vec(0.05 * static_cast<double>(i), -static_cast<double>(i), 2) + off, visible};
}

GroundTruthTracks tracks_of(const clip::Clip& clip, const std::vector<TruePosition>& positions) {
  GroundTruthTracks tracks;
  for (std::size_t i = 0; i < positions.size(); ++i) tracks[7][clip.capture_frames[i]] = positions[i];
  return tracks;
}

TEST(TrackError, OfATrueMotionIsNothing) {
  const clip::Clip clip = clip_of_walker();
  const auto report = track_error(clip, tracks_of(clip, {at(0, true), at(1, true), at(2, true), at(3, true)}));
  EXPECT_EQ(report.at("layer"), "anna");
  EXPECT_EQ(report.at("visible").at("places"), 3);
  EXPECT_NEAR(report.at("visible").at("error_m_mean").get<double>(), 0, 1e-6);
  EXPECT_EQ(report.at("hidden").at("places"), 0);
}

TEST(TrackError, IsTheMeanDistanceInMetresOfWhatIsSeenAndOfWhatIsHiddenApart) {
  const clip::Clip clip = clip_of_walker();
  const auto report = track_error(
      clip, tracks_of(clip, {at(0, true), at(1, true, {0.03, 0, 0.04}), at(2, false, {0, 0.2, 0}), at(3, true)}));
  EXPECT_EQ(report.at("visible").at("places"), 2);
  EXPECT_NEAR(report.at("visible").at("error_m_mean").get<double>(), 0.025, 1e-6);
  EXPECT_NEAR(report.at("visible").at("error_m_p95").get<double>(), 0.05, 1e-6);
  EXPECT_EQ(report.at("hidden").at("places"), 1);
  EXPECT_NEAR(report.at("hidden").at("error_m_mean").get<double>(), 0.2, 1e-6);
}

TEST(TrackError, BeginsAtTheFirstFrameThatShowsThePoint) {
  const clip::Clip clip = clip_of_walker();
  const auto report = track_error(clip, tracks_of(clip, {at(0, false, {0.5, 0, 0}), at(1, true), at(2, true)}));
  EXPECT_EQ(report.at("visible").at("places"), 1);
  EXPECT_NEAR(report.at("visible").at("error_m_mean").get<double>(), 0, 1e-6);
  EXPECT_NEAR(report.at("hidden").at("error_m_mean").get<double>(), 0.5, 1e-6);
}

TEST(TrackError, CountsFramesInWhichTheLayerIsLost) {
  clip::Clip clip = clip_of_walker();
  std::vector<motion::Motion::Pose> poses = clip.layers[1].motion.poses();
  poses[2].health = motion::Health::kLost;
  clip.layers[1].motion = motion::Motion::rigid(std::move(poses));
  const auto report = track_error(clip, tracks_of(clip, {at(0, true), at(1, true), at(2, true), at(3, true)}));
  EXPECT_EQ(report.at("visible").at("missing"), 1);
  EXPECT_EQ(report.at("visible").at("places"), 3);
}

TEST(TrackError, IsNullWithoutAPersonOrWithoutPoints) {
  clip::Clip clip = clip_of_walker();
  EXPECT_TRUE(track_error(clip, {}).is_null());
  const GroundTruthTracks tracks = tracks_of(clip, {at(0, true), at(1, true)});
  clip.layers[1].label = 2;
  EXPECT_TRUE(track_error(clip, tracks).is_null());
}

} // namespace
} // namespace kinora::evaluate
