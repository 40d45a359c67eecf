#include "player/window/viewer.h"

#include <algorithm>
#include <fstream>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "clip/sample_clip.h"
#include "core/error.h"
#include "player/camera_file.h"
#include "player/window/new_file.h"

namespace kinora::player::window {
namespace {

using enum Action::Kind;

Camera some_camera() { return {{40, 30, 50, 50, 19.5, 14.5}, SE3::Identity()}; }
const Eigen::Vector3d kPivot(0, 0, 2);

TEST(WindowKeys, MeanWhatTheDocumentationSays) {
  EXPECT_EQ(action_of(U' '), (Action{kPlayPause}));
  EXPECT_EQ(action_of(U','), (Action{kStep, -1}));
  EXPECT_EQ(action_of(U']'), (Action{kSpeed, 2}));
  EXPECT_EQ(action_of(U'3'), (Action{kLayer, 2}));
  EXPECT_EQ(action_of(SpecialKey::kRight), (Action{kSeekBy, 1}));
  EXPECT_EQ(action_of(SpecialKey::kEscape), (Action{kQuit}));
  EXPECT_EQ(action_of(U'\u00e9'), std::nullopt);
}

TEST(OrbitCamera, IsTheCaptureCameraUntilItIsMoved) {
  OrbitCamera camera(some_camera(), kPivot);
  EXPECT_EQ(camera.camera(80, 60).intrinsics, some_camera().intrinsics.resized(80, 60));
  Camera later = some_camera();
  later.camera_to_world.translation().x() = 1;
  camera.set_home(later);
  EXPECT_EQ(camera.camera(40, 30).camera_to_world.translation().x(), 1);
  camera.orbit(0.1, 0);
  const SE3 put = camera.camera(40, 30).camera_to_world;
  camera.set_home(some_camera());
  EXPECT_TRUE(camera.camera(40, 30).camera_to_world.isApprox(put));
  camera.reset();
  EXPECT_TRUE(camera.camera(40, 30).camera_to_world.isApprox(SE3::Identity()));
}

TEST(OrbitCamera, ShowsTheWholeCaptureInTheMiddleOfAWiderWindow) {
  const Intrinsics wide = fitted(some_camera().intrinsics, 120, 60);
  const Eigen::Vector2d middle = wide.project({0, 0, 1});
  EXPECT_DOUBLE_EQ(middle.x(), 59.5);
  EXPECT_DOUBLE_EQ(wide.fx, 100);
}

TEST(OrbitCamera, KeepsThePivotInItsPlaceAndItsDistance) {
  OrbitCamera camera(some_camera(), kPivot);
  for (const auto& [right, down] : {std::pair{0.3, 0.1}, {-0.7, 0.2}, {0.1, -5.0}, {0.0, 9.0}}) {
    camera.orbit(right, down);
    const Eigen::Vector3d seen = camera.camera(40, 30).camera_to_world.inverse() * kPivot;
    EXPECT_TRUE(seen.isApprox(Eigen::Vector3d(0, 0, 2), 1e-9)) << seen.transpose();
    EXPECT_GT(camera.camera(40, 30).camera_to_world.linear().col(1).y(), 0) << "upside down";
  }
}

TEST(OrbitCamera, WhatIsDraggedFollowsTheMouse) {
  const auto column_of = [](const OrbitCamera& camera, const Eigen::Vector3d& point) {
    const Camera at = camera.camera(40, 30);
    return at.intrinsics.project(at.camera_to_world.inverse() * point);
  };
  const Eigen::Vector3d near = kPivot - Eigen::Vector3d(0, 0, 0.5);
  OrbitCamera turned(some_camera(), kPivot);
  turned.orbit(0.05, 0.05);
  EXPECT_GT(column_of(turned, near).x(), 19.6);
  EXPECT_GT(column_of(turned, near).y(), 14.6);
  OrbitCamera panned(some_camera(), kPivot);
  panned.pan(0.1, 0.2);
  EXPECT_NEAR(column_of(panned, kPivot).x(), 19.5 + 3, 1e-9);
  EXPECT_NEAR(column_of(panned, kPivot).y(), 14.5 + 6, 1e-9);
}

TEST(OrbitCamera, ZoomNeverPassesThePivot) {
  OrbitCamera camera(some_camera(), kPivot);
  camera.zoom(1);
  EXPECT_NEAR(camera.camera(40, 30).camera_to_world.translation().z(), 0.2, 1e-9);
  camera.zoom(1000);
  EXPECT_LT(camera.camera(40, 30).camera_to_world.translation().z(), 2);
}

class ViewerTest : public ::testing::Test {
protected:
  ViewerTest() {
    std::filesystem::create_directories(folder_);
    clip::write_clip(clip::testing::sample_clip(1, 4, true), folder_ / "clip");
  }
  ~ViewerTest() override { std::filesystem::remove_all(folder_); }

  Viewer viewer() {
    const auto open = [this](const std::string& clip) {
      if (clip == "bad.mkv") throw Error(ErrorCode::kCorruptInput, "bad.mkv is no clip");
      return std::make_unique<ClipFeed>(std::make_unique<container::FileSource>(folder_ / "clip"));
    };
    return Viewer(
        "dir/some.mkv", open, folder_, [] { return false; }, [this] { return now_; });
  }

  double now_ = 0;
  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ::testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(ViewerTest, PlaysStepsAndSeeks) {
  Viewer viewer = this->viewer();
  EXPECT_TRUE(viewer.panel(32, 24).playing);
  now_ = 1000;
  EXPECT_EQ(viewer.panel(32, 24).frame, 3U);
  EXPECT_FALSE(viewer.panel(32, 24).playing);
  viewer.act({kSeek, 0});
  viewer.act({kStep, 2});
  viewer.act({kStep, -1});
  EXPECT_EQ(viewer.panel(32, 24).frame, 1U);
  viewer.act({kSeekBy, -1});
  EXPECT_EQ(viewer.panel(32, 24).frame, 0U);
  for (int i = 0; i < 20; ++i) viewer.act({kSpeed, 2});
  EXPECT_EQ(viewer.panel(32, 24).speed, PlaybackClock::kMaxSpeed);
  viewer.act({kLoop});
  EXPECT_TRUE(viewer.panel(32, 24).loop);
  EXPECT_FALSE(viewer.ended());
  viewer.act({kQuit});
  EXPECT_TRUE(viewer.ended());
}

TEST_F(ViewerTest, TwoHundredRandomSeeksLeadToTheirFrames) {
  Viewer viewer = this->viewer();
  viewer.act({kPlayPause});
  const std::vector<double> times = clip::testing::sample_clip(1, 4, true).times;
  std::mt19937 random(3); // NOLINT: the same seeks each time
  std::uniform_real_distribution<double> seconds(times.front(), times.back());
  for (int i = 0; i < 200; ++i) {
    const double wanted = seconds(random);
    viewer.act({kSeek, wanted});
    const auto after = std::upper_bound(times.begin(), times.end(), wanted);
    EXPECT_EQ(viewer.panel(32, 24).frame, static_cast<std::size_t>(after - times.begin()) - 1) << wanted;
  }
}

TEST_F(ViewerTest, TellsWhereItsPicturesAreSeenFrom) {
  Viewer viewer = this->viewer();
  std::vector<SE3> told;
  viewer.tell_camera([&](const SE3& pose) { told.push_back(pose); });
  viewer.panel(32, 24);
  ASSERT_EQ(told.size(), 1U);
  viewer.orbit(0.2, 0);
  viewer.panel(32, 24);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_GT(rotation_angle(told[0].inverse() * told[1]), 0.5);
}

TEST_F(ViewerTest, WindowsOf8KAndOfOnePixelAreDrawn) {
  Viewer viewer = this->viewer();
  for (const auto& [width, height] : {std::pair{7680, 4320}, {1, 1}}) {
    viewer.panel(width, height);
    const auto drawn = [&, w = width] {
      const auto picture = viewer.picture();
      return picture && (w == 1 ? picture->width() == 1 : picture->width() >= w / 8);
    };
    while (!drawn()) std::this_thread::yield();
    const auto picture = viewer.picture();
    EXPECT_NEAR(picture->height(), static_cast<double>(picture->width()) * height / width, 1);
  }
}

TEST_F(ViewerTest, KeepsTheClipIfAnotherCannotBeOpened) {
  Viewer viewer = this->viewer();
  viewer.open("bad.mkv");
  EXPECT_EQ(viewer.panel(32, 24).title, "some.mkv");
  EXPECT_EQ(viewer.panel(32, 24).message, "bad.mkv is no clip");
  viewer.open("other.mkv");
  EXPECT_EQ(viewer.panel(32, 24).title, "other.mkv");
}

TEST_F(ViewerTest, RecordsACameraPathThatIsReadAgain) {
  Viewer viewer = this->viewer();
  viewer.act({kPlayPause});
  viewer.act({kStep, 1});
  viewer.act({kRecord});
  viewer.orbit(0.1, 0);
  viewer.panel(32, 24);
  EXPECT_EQ(viewer.finish(), "transforms.json written, 1 cameras");
  Progress progress;
  const auto views = read_camera_file(folder_ / "transforms.json", clip::testing::sample_clip(1, 4, true), progress);
  ASSERT_EQ(views.size(), 1U);
  EXPECT_NEAR(views[0].frame, 1, 1e-6);
  EXPECT_EQ(views[0].camera.intrinsics.width, 32);
}

TEST_F(ViewerTest, NeverWritesOverAFile) {
  const auto text = std::as_bytes(std::span("new"));
  std::ofstream(folder_ / "a.png") << "old";
  EXPECT_EQ(write_new_file(folder_, "a", ".png", text), folder_ / "a-2.png");
  EXPECT_EQ(std::filesystem::file_size(folder_ / "a.png"), 3U);
  EXPECT_THROW(write_new_file(folder_ / "none", "a", ".png", text), Error);
}

} // namespace
} // namespace kinora::player::window
