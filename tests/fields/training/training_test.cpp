// A small analytic scene is learnt from its frames and drawn again: the whole room, end to end.
#include <gtest/gtest.h>

#include <numbers>

#include "core/metrics.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/analytic_scene.h"
#include "fields/scenes/normal_error.h"
#include "fields/training/trainer.h"

namespace kinora::fields {
namespace {

class EitherGeometry : public ::testing::TestWithParam<Geometry> {};

INSTANTIATE_TEST_SUITE_P(Training, EitherGeometry, ::testing::Values(Geometry::kDensity, Geometry::kSignedDistance),
                         [](const auto& geometry) { return name_of(geometry.param); });

TEST_P(EitherGeometry, LearnsBallAndWallAsTwoLayersThatHideEachOther) {
  const Scene scene;
  const PixelStore store = store_of(scene);
  const auto still = motion::Motion::still();
  Progress progress;
  std::vector<DrawableField> fields;
  for (const int label : {0, 2}) {
    FieldConfig config = choose_field_config({store, label, still});
    config.geometry = GetParam();
    fields.emplace_back(train_field({store, label, still}, config, short_training(), progress));
  }
  const ingest::Frame held_out = scene.frame(0, 0.125);
  const std::vector<PosedField> layers = {{&fields[0], SE3::Identity(), nullptr},
                                          {&fields[1], SE3::Identity(), nullptr}};
  const Picture picture = render(layers, held_out.camera);
  EXPECT_GT(compare_images(picture.color, held_out.color).psnr_full, 24);

  const Picture ball = render(std::span(layers).subspan(1), held_out.camera, {.normals = true});
  const ImageMetrics alone = compare_images(ball.color, held_out.color, held_out.labels);
  EXPECT_GT(alone.psnr_inside, 24);
  EXPECT_GT(alone.iou, 0.93);
  const auto normal_of = [&](const Eigen::Vector3d& point) {
    return Eigen::Vector3d((point - scene.centre).normalized());
  };
  const testing::NormalError normals = testing::normal_error(ball, held_out.camera, normal_of);
  EXPECT_LT(normals.mean, 10);

  std::vector<float> errors;
  std::size_t right_layer = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      errors.push_back(std::abs(picture.depth.at(u, v) - held_out.depth.at(u, v)));
      right_layer += picture.front.at(u, v) == (held_out.labels.at(u, v) == 2 ? 2 : 1) ? 1U : 0U;
    }
  }
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.012F);
  EXPECT_GT(static_cast<double>(right_layer) / errors.size(), 0.97);
}

TEST(Training, NeedsFewerSamplesWhereDepthIsExact) {
  const Scene scene;
  const PixelStore store = store_of(scene);
  const auto still = motion::Motion::still();
  const FieldConfig config = choose_field_config({store, 2, still});
  const ingest::Frame held_out = scene.frame(0, 0.125);
  std::array<double, 2> psnr{};
  std::array<std::size_t, 2> samples{};
  for (const bool exact : {false, true}) {
    TrainerConfig trainer = short_training();
    trainer.exact_depth = exact;
    Progress progress;
    TrainingReport report;
    const DrawableField field(train_field({store, 2, still}, config, trainer, progress, &report));
    const PosedField posed{&field, SE3::Identity(), nullptr};
    const Picture ball = render({&posed, 1}, held_out.camera);
    psnr[exact] = compare_images(ball.color, held_out.color, held_out.labels).psnr_inside;
    samples[exact] = report.samples;
  }
  EXPECT_GT(psnr[1], psnr[0] - 0.3);
  EXPECT_LT(static_cast<double>(samples[1]), 0.9 * static_cast<double>(samples[0]));
}

TEST(Training, FollowsARigidLayerThatMoves) {
  // The same ball, but now the ball moves and the camera stands: canonical space is that of frame 0.
  const Scene scene;
  PixelStore store(1'000'000, 8);
  std::vector<motion::Motion::Pose> poses;
  for (int i = 0; i < 8; ++i) {
    Scene moved = scene;
    moved.centre += Eigen::Vector3d(0.03 * i, -0.01 * i, 0.02 * i);
    ingest::Frame frame = moved.frame(i, 0);
    frame.camera.camera_to_world = SE3::Identity();
    // The chequers are fixed in space, not on the ball: colour it evenly instead.
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        if (frame.labels.at(u, v) == 2) std::fill_n(frame.color.pixel(u, v), 3, std::uint8_t{200});
      }
    }
    store.add(frame, i);
    motion::Motion::Pose pose;
    pose.canonical_to_world.translation() = moved.centre - scene.centre;
    poses.push_back(pose);
  }
  const auto motion = motion::Motion::rigid(poses);
  Progress progress;
  const DrawableField ball(
      train_field({store, 2, motion}, choose_field_config({store, 2, motion}), short_training(), progress));
  for (const int at : {0, 7}) {
    Scene moved = scene;
    moved.centre += Eigen::Vector3d(0.03 * at, -0.01 * at, 0.02 * at);
    const ingest::Frame truth = moved.frame(at, 0);
    const PosedField posed = pose(ball, motion.warp(at));
    const Picture picture = render({&posed, 1}, truth.camera);
    EXPECT_GT(compare_images(picture.color, truth.color, truth.labels).iou, 0.93) << "frame " << at;
  }
}

TEST(Renderer, AcceptsEveryCamera) {
  const PixelStore store = store_of(Scene{});
  const auto still = motion::Motion::still();
  TrainerConfig trainer = short_training();
  trainer.rays = 50'000;
  Progress progress;
  const DrawableField ball(train_field({store, 2, still}, choose_field_config({store, 2, still}), trainer, progress));
  const PosedField posed = pose(ball, motion::Warp(SE3::Identity()));
  Camera camera = Scene{}.frame(0, 0).camera;
  camera.camera_to_world.translation() = Eigen::Vector3d(0, 0, 2); // inside
  EXPECT_EQ(render({&posed, 1}, camera).color.width(), kWidth);
  camera.camera_to_world.translation() = Eigen::Vector3d(0, 0, 9); // behind, looking away
  const Picture away = render({&posed, 1}, camera);
  EXPECT_TRUE(std::all_of(away.color.values().begin(), away.color.values().end(), [](auto v) { return v == 0; }));
  camera.intrinsics = {1, 1, 80, 80, 0, 0};
  EXPECT_EQ(render({&posed, 1}, camera).depth.pixel_count(), 1U);
  EXPECT_EQ(render({}, camera).color.at(0, 0, 3), 0);
  camera.intrinsics.width = 0;
  EXPECT_ANY_THROW(render({&posed, 1}, camera));
}

// A white ball that turns by 15° from frame to frame, in light from the left.
TEST(Training, LearnsTheLightThatALayerTurnsIn) {
  const Scene scene;
  PixelStore store(1'000'000, 12);
  std::vector<motion::Motion::Pose> poses;
  ingest::Frame held_out;
  for (int i = 0; i < 12; ++i) {
    ingest::Frame frame = scene.frame(i, 0);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        if (frame.labels.at(u, v) != 2) continue;
        const Eigen::Vector3d point = frame.camera.intrinsics.unproject(u, v, frame.depth.at(u, v));
        const double light = std::max(0.0, (point - scene.centre).normalized().dot(Eigen::Vector3d(-0.8, 0, -0.6)));
        std::fill_n(frame.color.pixel(u, v), 3, static_cast<std::uint8_t>(std::lround(40 + 200 * light)));
      }
    }
    motion::Motion::Pose pose;
    pose.canonical_to_world.linear() =
        Eigen::AngleAxisd(i * std::numbers::pi / 12, Eigen::Vector3d::UnitY()).toRotationMatrix();
    pose.canonical_to_world.translation() = scene.centre - pose.canonical_to_world.linear() * scene.centre;
    poses.push_back(pose);
    if (i == 6) {
      held_out = frame;
    } else {
      store.add(frame, i);
    }
  }
  const auto motion = motion::Motion::rigid(poses);
  Progress progress;
  const DrawableField field(
      train_field({store, 2, motion}, choose_field_config({store, 2, motion}), short_training(), progress));
  const PosedField posed = pose(field, motion.warp(6));
  const Picture picture = render({&posed, 1}, held_out.camera);
  EXPECT_GT(compare_images(picture.color, held_out.color, held_out.labels).psnr_inside, 33);
}

} // namespace
} // namespace kinora::fields
