#include "player/player.h"

#include <gtest/gtest.h>

#include "clip/sample_clip.h"
#include "fields/scenes/painted_field.h"
#include "player/picture_view.h"

namespace kinora::player {
namespace {

TEST(PlayerLayers, NothingChosenDrawsNothing) {
  const Player player(clip::testing::sample_clip(1, 3, false));
  Camera camera = player.clip().capture_camera(0);
  camera.intrinsics = camera.intrinsics.resized(16, 12);
  const fields::Picture picture = player.draw(camera, 0, {});
  ASSERT_EQ(picture.color.pixel_count(), 16U * 12U);
  for (std::size_t i = 0; i < picture.color.pixel_count(); ++i) ASSERT_EQ(picture.color.data()[4 * i + 3], 0);
}

TEST(PlayerLayers, AreFoundByLabel) {
  const Player player(clip::testing::sample_clip(1, 3, false));
  EXPECT_EQ(player.layer_with_label(2), 1U);
  EXPECT_EQ(player.layer_with_label(7), std::nullopt);
}

TEST(PlayerLayers, AreNotDrawnBeforeTheyWereFirstSeen) {
  clip::Clip clip = clip::testing::sample_clip(1, 4, false);
  std::vector<motion::Motion::Pose> poses(4, {SE3::Identity(), motion::Health::kLost});
  poses[2].health = motion::Health::kTracked;
  clip.layers[1].motion = motion::Motion::rigid(std::move(poses));
  const Player player(std::move(clip));
  const Eigen::Vector3d centre = player.centre_of(1, 2).value();
  Camera camera{{32, 24, 30, 30, 15.5, 11.5}, SE3(Eigen::Translation3d(centre - Eigen::Vector3d(0, 0, 1.2)))};
  const auto drawn_pixels = [&](double frame) {
    const fields::Picture picture = player.draw(camera, frame, {1});
    int count = 0;
    for (std::size_t i = 0; i < picture.color.pixel_count(); ++i) count += picture.color.data()[4 * i + 3] > 0 ? 1 : 0;
    return count;
  };
  EXPECT_EQ(drawn_pixels(1), 0);
  EXPECT_GT(drawn_pixels(2), 0);
  EXPECT_GT(drawn_pixels(3), 0);
}

TEST(PlayerLayers, AreNeitherDrawnNorCountedWhereTheyAreAway) {
  clip::Clip clip = clip::testing::sample_clip(1, 6, false);
  clip.layers[1].motion = motion::Motion::rigid(std::vector<motion::Motion::Pose>(6));
  for (clip::Layer& layer : clip.layers) layer.presence = motion::Presence::away_during({{0, 2}, {4, 6}});
  const Player player(std::move(clip));
  const Eigen::Vector3d centre = player.centre_of(1, 2).value();
  Camera camera{{32, 24, 30, 30, 15.5, 11.5}, SE3(Eigen::Translation3d(centre - Eigen::Vector3d(0, 0, 1.2)))};
  const auto is_seen = [&](double frame) {
    const fields::Picture picture = player.draw(camera, frame, {0, 1});
    return std::any_of(picture.front.values().begin(), picture.front.values().end(), [](auto v) { return v > 0; });
  };
  for (const double frame : {-1.0, 0.0, 1.9, 4.0, 5.0, 99.0}) {
    EXPECT_FALSE(is_seen(frame)) << frame;
    EXPECT_FALSE(player.centre_of(1, frame).has_value()) << frame;
    EXPECT_TRUE(player.drawn_health(frame, {0, 1}).empty()) << frame;
    EXPECT_TRUE(player.posed_layers(frame, {0, 1}).empty()) << frame;
  }
  for (const double frame : {2.0, 3.0, 3.9}) {
    EXPECT_TRUE(is_seen(frame)) << frame;
    EXPECT_EQ(player.drawn_layers(frame, {0, 1}), (LayerChoice{0, 1})) << frame;
  }
}

TEST(PlayerLayers, PartsAreDrawnOnceTheirNodesAreBorn) {
  clip::Clip clip = clip::testing::sample_clip(1, 6, false);
  clip.layers.resize(1);
  clip.layers[0].field = fields::testing::painted_field({{-0.5, -0.5, -0.5}, 1}, fields::testing::PaintedBall{});
  clip.layers[0].confidence.reset();
  const auto graph = std::make_shared<const motion::DeformationGraph>(
      std::vector<Eigen::Vector3d>{{-0.2, 0, 0}, {0.2, 0, 0}}, 0.2, 1.0);
  const DualQuaternion still = DualQuaternion::from(SE3::Identity());
  clip.layers[0].motion =
      motion::Motion::deforming(graph, std::vector<motion::Motion::Deformation>(6, {{still, still}}));
  clip.layers[0].births = motion::NodeBirths({0, 3});
  const Player player(std::move(clip));
  const Camera camera{{64, 48, 60, 60, 31.5, 23.5}, SE3(Eigen::Translation3d(0, 0, -1.2))};
  const auto drawn = [&](double frame) {
    const fields::Picture picture = player.draw(camera, frame, {0});
    return std::count_if(picture.front.values().begin(), picture.front.values().end(), [](auto v) { return v > 0; });
  };
  EXPECT_GT(drawn(0), 100);
  EXPECT_LT(drawn(0), 0.7 * static_cast<double>(drawn(3)));
  EXPECT_EQ(drawn(2.9), drawn(0));
  EXPECT_EQ(drawn(5), drawn(3));
}

TEST(PlayerHealth, IsOfTheLayersThatAreDrawnAndColoursThem) {
  clip::Clip clip = clip::testing::sample_clip(1, 4, false);
  const std::size_t still = 0, moving = 1;
  std::vector<motion::Motion::Pose> poses(4, {SE3::Identity(), motion::Health::kLost});
  poses[1].health = motion::Health::kTracked;
  poses[2].health = motion::Health::kHeld;
  clip.layers[moving].motion = motion::Motion::rigid(std::move(poses));
  const Player player(std::move(clip));
  using enum motion::Health;
  EXPECT_EQ(player.drawn_health(0.5, {still, moving}), (std::vector{kTracked}));
  EXPECT_EQ(player.drawn_health(1.9, {moving}), (std::vector{kTracked}));
  EXPECT_EQ(player.drawn_health(2, {moving, still}), (std::vector{kHeld, kTracked}));
  EXPECT_EQ(player.drawn_health(99, {moving}), (std::vector{kLost}));

  fields::Picture picture{ColorImage(3, 1, 4), DepthImage(3, 1, 1), LabelImage(3, 1, 1)};
  std::fill_n(picture.color.data(), 12, std::uint8_t{255});
  picture.front.data()[1] = 1;
  picture.front.data()[2] = 2;
  const ColorImage image = painted(picture, PictureView::kHealth, {kHeld, kLost});
  const auto at = [&](int u) { return std::vector<int>(image.pixel(u, 0), image.pixel(u, 0) + 3); };
  EXPECT_EQ(at(0), (std::vector{255, 255, 255}));
  EXPECT_EQ(at(1), (std::vector{255, 255, 0}));
  EXPECT_EQ(at(2), (std::vector{255, 0, 0}));
}

TEST(PlayerCentre, MovesWithTheLayer) {
  clip::Clip clip = clip::testing::sample_clip(1, 2, false);
  fields::Field& field = clip.layers[1].field;
  field.occupancy = fields::Occupancy(field.config.occupancy_resolution);
  field.occupancy.set(10, 20, 30);
  field.occupancy.set(12, 20, 30);
  const double cell = field.config.box.side / field.config.occupancy_resolution;
  const Eigen::Vector3d canonical = field.config.box.origin + cell * Eigen::Vector3d(11.5, 20.5, 30.5);
  const SE3 pose = clip.layers[1].motion.canonical_to_world(1);
  const Player player(std::move(clip));
  EXPECT_LT((player.centre_of(1, 1).value() - pose * canonical).norm(), 1e-9);
}

TEST(PlayerCentre, OfAnEmptyLayerIsNothing) {
  clip::Clip clip = clip::testing::sample_clip(1, 2, false);
  clip.layers[0].field.occupancy = fields::Occupancy(clip.layers[0].field.config.occupancy_resolution);
  EXPECT_FALSE(Player(std::move(clip)).centre_of(0, 0).has_value());
}

TEST(PlayerSize, PicturesSmallerThanTheCaptureGetMoreSamples) {
  const Intrinsics capture{640, 480, 500, 500, 319.5, 239.5};
  EXPECT_EQ(samples_per_side(capture.resized(1280, 960), capture), 1);
  EXPECT_EQ(samples_per_side(capture, capture), 1);
  EXPECT_EQ(samples_per_side(capture.resized(320, 240), capture), 2);
  EXPECT_EQ(samples_per_side(capture.resized(160, 120), capture), 4);
  EXPECT_EQ(samples_per_side(capture.resized(8, 6), capture), 8);
}

TEST(PlayerTime, DrawingAtATimeIsDrawingAtItsFrame) {
  const Player player(clip::testing::sample_clip(5, 4, true));
  Camera camera = player.clip().capture_camera(2);
  camera.intrinsics = camera.intrinsics.resized(24, 18);
  const fields::Picture by_frame = player.draw(camera, 2, player.all_layers());
  const fields::Picture by_time = player.draw_at(camera, player.clip().times[2], player.all_layers());
  EXPECT_TRUE(std::equal(by_frame.color.values().begin(), by_frame.color.values().end(), by_time.color.values().begin(),
                         by_time.color.values().end()));
}

// How far apart the colours of two pictures are, of 255, in the mean.
double difference(const fields::Picture& a, const fields::Picture& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.color.values().size(); ++i) sum += std::abs(a.color.data()[i] - b.color.data()[i]);
  return sum / static_cast<double>(a.color.values().size());
}

/// A ball that goes 20 cm to the right from one frame to the next, as a rigid thing or on a graph of two nodes.
Player ball_on_its_way(bool deforms) {
  clip::Clip clip = clip::testing::sample_clip(1, 2, false);
  clip.layers.resize(1);
  clip.layers[0].field = fields::testing::painted_field({{-0.5, -0.5, -0.5}, 1}, fields::testing::PaintedBall{});
  clip.layers[0].confidence.reset();
  const std::array<SE3, 2> poses{SE3::Identity(), SE3(Eigen::Translation3d(0.2, 0, 0))};
  if (!deforms) {
    clip.layers[0].motion = motion::Motion::rigid({{poses[0]}, {poses[1]}});
    return Player(std::move(clip));
  }
  const auto graph = std::make_shared<const motion::DeformationGraph>(
      std::vector<Eigen::Vector3d>{{-0.1, 0, 0}, {0.1, 0, 0}}, 0.5, 1.0);
  std::vector<motion::Motion::Deformation> deformations;
  deformations.reserve(poses.size());
  for (const SE3& pose : poses) deformations.push_back({{DualQuaternion::from(pose), DualQuaternion::from(pose)}});
  clip.layers[0].motion = motion::Motion::deforming(graph, std::move(deformations));
  return Player(std::move(clip));
}

class PlayerBetweenFrames : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(PlayerTime, PlayerBetweenFrames, ::testing::Bool());

// A camera that goes along sees the same at every time.
TEST_P(PlayerBetweenFrames, LayersAreHalfWay) {
  const Player player = ball_on_its_way(GetParam());
  const auto drawn = [&](double frame, double camera_x) {
    const Camera camera{{32, 24, 30, 30, 15.5, 11.5}, SE3(Eigen::Translation3d(camera_x, 0, -1.2))};
    return player.draw(camera, frame, {0});
  };
  EXPECT_GT(difference(drawn(0, 0), drawn(0, 0.1)), 5) << "the ball beside the middle is another picture";
  EXPECT_LT(difference(drawn(0, 0), drawn(0.5, 0.1)), 1);
  EXPECT_LT(difference(drawn(0, 0), drawn(1, 0.2)), 1) << "and is drawn anew for each time";
}

} // namespace
} // namespace kinora::player
