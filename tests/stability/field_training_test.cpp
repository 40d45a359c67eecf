// Whole trainings of a small scene whose frames, place, size or learning rates are not as they should be. What each may
// cost is stated in dB below kAlike, which the clean scene reaches, of a view that no training saw.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "core/error.h"
#include "core/metrics.h"
#include "core/random.h"
#include "fields/network/instruction_set.h"
#include "fields/rendering/renderer.h"
#include "fields/scenes/analytic_scene.h"
#include "fields/training/trainer.h"

namespace kinora::fields {
namespace {

constexpr int kBall = 2;
constexpr int kFrames = 12;
constexpr double kHeldOutAngle = 0.125;

/// dB: a picture beyond it is hardly told from the truth, and losing some of them is no loss.
constexpr double kAlike = 40;

using Change = std::function<void(ingest::Frame&)>;

struct Trial {
  Change disturb = [](ingest::Frame&) {};  // the frames that are trained on
  Change position = [](ingest::Frame&) {}; // all frames
  Scene scene = {};
  TrainerConfig trainer = short_training();
};

struct Outcome {
  double psnr;        // of the picture, silhouette included
  double psnr_inside; // where ball and picture of it meet
  double iou;
  double depth_error; // metres, the median where ball and picture of it meet
  TrainingReport report;
  std::vector<std::string> warnings;
};

class Listener : public Progress {
public:
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }
  std::vector<std::string> warnings;
};

double median_depth_error(const Picture& picture, const ingest::Frame& truth) {
  std::vector<float> errors;
  for (std::size_t i = 0; i < picture.depth.pixel_count(); ++i) {
    const float depth = picture.depth.values()[i];
    if (depth > 0 && truth.labels.values()[i] == kBall) errors.push_back(std::abs(depth - truth.depth.values()[i]));
  }
  if (errors.empty()) return 1e9;
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  return errors[errors.size() / 2];
}

Outcome learn_ball(const Trial& trial) {
  PixelStore store(1'000'000, kFrames);
  for (int i = 0; i < kFrames; ++i) {
    ingest::Frame frame = trial.scene.frame(i, 0.05 * i - 0.3);
    trial.position(frame);
    trial.disturb(frame);
    store.add(frame, i);
  }
  const auto still = motion::Motion::still();
  Listener progress;
  TrainingReport report;
  const DrawableField ball(
      train_field({store, kBall, still}, choose_field_config({store, kBall, still}), trial.trainer, progress, &report));
  ingest::Frame held_out = trial.scene.frame(0, kHeldOutAngle);
  trial.position(held_out);
  const PosedField posed = pose(ball, motion::Warp(SE3::Identity()));
  const Picture picture = render({&posed, 1}, held_out.camera);
  const ImageMetrics metrics = compare_images(picture.color, held_out.color, held_out.labels);
  return {std::min(metrics.psnr_box, kAlike),
          std::min(metrics.psnr_inside, kAlike),
          metrics.iou,
          median_depth_error(picture, held_out),
          report,
          progress.warnings};
}

void for_each_depth(ingest::Frame& frame, const std::function<float(float)>& change) {
  for (float& depth : frame.depth.values()) depth = change(depth);
  frame.clean_depth = frame.depth;
}

/// The scene as if everything in it were `factor` times as large.
Change scaled(double factor) {
  return [factor](ingest::Frame& frame) {
    frame.camera.camera_to_world.translation() *= factor;
    for_each_depth(frame, [factor](float depth) { return static_cast<float>(factor) * depth; });
  };
}

TEST(DisturbedTraining, CleanSceneIsLearntAsIfUndisturbed) {
  const Outcome clean = learn_ball({});
  EXPECT_EQ(clean.psnr, kAlike);
  EXPECT_LT(clean.depth_error, 0.004);
  EXPECT_TRUE(clean.report.restarts.empty());
}

TEST(DisturbedTraining, BearsDepthNoiseOfOnePercent) {
  const auto noise = [](ingest::Frame& frame) {
    Random random(31, static_cast<std::uint64_t>(frame.index));
    for_each_depth(frame, [&](float depth) { return depth * (1 + 0.01F * static_cast<float>(random.normal())); });
  };
  EXPECT_GT(learn_ball({noise}).psnr, kAlike - 2);
}

TEST(DisturbedTraining, BearsThatEveryTenthDepthIsWrongByUpToThirtyCentimetres) {
  const auto wild = [](ingest::Frame& frame) {
    Random random(34, static_cast<std::uint64_t>(frame.index));
    for_each_depth(frame, [&](float depth) {
      return random.uniform() < 0.1F ? depth + 0.3F * (2 * random.uniform() - 1) : depth;
    });
  };
  const Outcome outcome = learn_ball({wild});
  EXPECT_GT(outcome.psnr, kAlike - 1);
  EXPECT_GT(outcome.psnr_inside, kAlike - 1);
  EXPECT_LT(outcome.depth_error, 0.006); // 0.003 of the clean scene; the noise of the sensor there is 0.005
}

TEST(DisturbedTraining, BearsADepthBiasOfOneCentimetre) {
  const auto bias = [](ingest::Frame& frame) { for_each_depth(frame, [](float depth) { return depth + 0.01F; }); };
  EXPECT_GT(learn_ball({bias}).psnr, kAlike - 2);
}

TEST(DisturbedTraining, BearsDepthThatLiesThreePixelsBesideColour) {
  const auto shift = [](ingest::Frame& frame) {
    const DepthImage there = frame.depth;
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) frame.depth.at(u, v) = there.at(std::min(u + 3, kWidth - 1), v);
    }
    frame.clean_depth = frame.depth;
  };
  // The ball is 24 pixels wide: a sixth of it is said to be wall.
  const Outcome outcome = learn_ball({shift});
  EXPECT_GT(outcome.iou, 0.75);
  EXPECT_GT(outcome.psnr_inside, kAlike - 15);
}

TEST(DisturbedTraining, BearsFlickerOfTwentyPercent) {
  // Even the best single colour of a point is wrong by a standard deviation of 12 %: 23 dB.
  const auto flicker = [](ingest::Frame& frame) {
    Random random(32, static_cast<std::uint64_t>(frame.index));
    const double gain = 0.8 + 0.4 * random.uniform_double();
    for (auto& value : frame.color.values()) value = static_cast<std::uint8_t>(std::min(gain * value, 255.0));
  };
  EXPECT_GT(learn_ball({flicker}).psnr, kAlike - 12);
}

TEST(DisturbedTraining, LearnsALayerOfTwoCentimetres) {
  EXPECT_GT(learn_ball({.position = scaled(0.01 / 0.3)}).psnr, kAlike - 2);
}

TEST(DisturbedTraining, LearnsALayerOfTwentyMetres) {
  EXPECT_GT(learn_ball({.scene = {{0, 0, 14}, 10, 30, 0.6}}).psnr_inside, kAlike - 5);
}

TEST(DisturbedTraining, DoesNotMindBeingAKilometreAway) {
  const auto move = [](ingest::Frame& frame) {
    frame.camera.camera_to_world.translation() += Eigen::Vector3d(1000, -1000, 1000);
  };
  EXPECT_GT(learn_ball({.position = move}).psnr, kAlike - 0.5);
}

TEST(DisturbedTraining, KeepsAStructureOfOnePixel) {
  // A red wire before a wall, one pixel wide, and the only thing of its layer.
  constexpr int kColumn = kWidth / 2;
  const auto wire = [](ingest::Frame& frame) {
    std::fill(frame.labels.values().begin(), frame.labels.values().end(), std::uint8_t{0});
    for (int v = 10; v < 50; ++v) {
      frame.labels.at(kColumn, v) = kBall;
      frame.depth.at(kColumn, v) = 1.7F;
      const std::array<std::uint8_t, 3> red{230, 20, 20};
      std::copy(red.begin(), red.end(), frame.color.pixel(kColumn, v));
    }
    frame.clean_depth = frame.depth;
  };
  ingest::Frame frame = Scene{}.frame(0, 0);
  wire(frame);
  PixelStore store(100'000, 1);
  store.add(frame, 0);
  const auto still = motion::Motion::still();
  Progress progress;
  const DrawableField field(
      train_field({store, kBall, still}, choose_field_config({store, kBall, still}), short_training(), progress));
  const PosedField posed = pose(field, motion::Warp(SE3::Identity()));
  const ImageMetrics metrics = compare_images(render({&posed, 1}, frame.camera).color, frame.color, frame.labels);
  EXPECT_GT(metrics.iou, 0.7);
  EXPECT_GT(metrics.psnr_inside, 25);
}

TEST(DisturbedTraining, LearnsFromASinglePixel) {
  ingest::Frame frame = Scene{}.frame(0, 0);
  std::fill(frame.labels.values().begin(), frame.labels.values().end(), std::uint8_t{0});
  constexpr int kU = 40;
  constexpr int kV = 30;
  frame.labels.at(kU, kV) = kBall;
  PixelStore store(100'000, 1);
  store.add(frame, 0);
  const auto still = motion::Motion::still();
  TrainerConfig trainer = short_training();
  trainer.rays = 50'000;
  Progress progress;
  const DrawableField field(
      train_field({store, kBall, still}, choose_field_config({store, kBall, still}), trainer, progress));
  const auto& table = field.field().table;
  EXPECT_TRUE(std::all_of(table.begin(), table.end(), [](float v) { return std::isfinite(v); }));
  const PosedField posed = pose(field, motion::Warp(SE3::Identity()));
  const Picture picture = render({&posed, 1}, frame.camera);
  EXPECT_GT(picture.color.at(kU, kV, 3), 240);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(picture.color.at(kU, kV, c), frame.color.at(kU, kV, c), 8) << c;
  EXPECT_NEAR(picture.depth.at(kU, kV), frame.depth.at(kU, kV), 0.02);
}

TEST(DisturbedTraining, OfAHallInFineDetailWorksInSixteenMegabytes) {
  PixelStore store(100'000, 2);
  for (const int i : {0, 1}) {
    ingest::Frame frame = Scene{}.frame(i, 0);
    frame.camera.intrinsics.fx = frame.camera.intrinsics.fy = 1000; // pixels of 2 mm
    frame.camera.camera_to_world.translation() += Eigen::Vector3d(20.0 * i, 0, 0);
    store.add(frame, i);
  }
  const auto still = motion::Motion::still();
  const FieldConfig config = choose_field_config({store, 0, still});
  EXPECT_EQ(config.finest_resolution, 2048);
  TrainerConfig trainer = short_training();
  trainer.rays = 1000;
  Progress progress;
  TrainingReport report;
  train_field({store, 0, still}, config, trainer, progress, &report);
  EXPECT_LE(report.bytes, 16'000'000U);
}

TEST(DisturbedTraining, SaysThatNothingCanBeLearntFromBackgroundAlone) {
  ingest::Frame frame = Scene{}.frame(0, 0);
  PixelStore store(100'000, 1);
  store.add(frame, 0);
  Progress progress;
  const auto still = motion::Motion::still();
  EXPECT_THROW(choose_field_config({store, 7, still}), Error);
  EXPECT_THROW(train_field({store, 7, still}, {}, short_training(), progress), Error);
  PixelStore empty(100'000, 1);
  EXPECT_THROW(train_field({empty, 0, still}, {}, short_training(), progress), Error);
}

class TooLargeSteps : public ::testing::TestWithParam<float> {};

TEST_P(TooLargeSteps, AreNoticedAndTakenSmaller) {
  Trial trial;
  trial.trainer.learning_rates.table *= GetParam();
  trial.trainer.learning_rates.nets *= GetParam();
  const Outcome outcome = learn_ball(trial);
  ASSERT_FALSE(outcome.report.restarts.empty());
  EXPECT_EQ(outcome.report.restarts.front(), Collapse::kOneColor) << "every number stays finite";
  ASSERT_EQ(outcome.warnings.size(), outcome.report.restarts.size());
  EXPECT_NE(outcome.warnings.front().find("everything is of one colour"), std::string::npos)
      << outcome.warnings.front();
  EXPECT_GT(outcome.psnr, kAlike - 5);
}

INSTANTIATE_TEST_SUITE_P(DisturbedTraining, TooLargeSteps, ::testing::Values(30.0F, 100.0F),
                         [](const auto& times) { return fmt::format("{:.0f}Times", times.param); });

TEST(DisturbedTraining, EndsAlikeOnEveryInstructionSet) {
  const Scene scene;
  const auto still = motion::Motion::still();
  const PixelStore store = store_of(scene);
  const FieldConfig config = choose_field_config({store, kBall, still});
  const ingest::Frame held_out = scene.frame(0, kHeldOutAngle);
  TrainerConfig trainer = short_training();
  trainer.rays = 60'000;
  std::vector<double> psnrs;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    ASSERT_STREQ(kernels::instruction_set(), hwy::TargetName(target));
    Progress progress;
    const DrawableField ball(train_field({store, kBall, still}, config, trainer, progress));
    const PosedField posed = pose(ball, motion::Warp(SE3::Identity()));
    psnrs.push_back(
        compare_images(render({&posed, 1}, held_out.camera).color, held_out.color, held_out.labels).psnr_box);
  }
  hwy::SetSupportedTargetsForTest(0);
  EXPECT_GT(psnrs.size(), 1U);
  const auto [least, most] = std::minmax_element(psnrs.begin(), psnrs.end());
  EXPECT_LT(*most - *least, 0.1);
}

} // namespace
} // namespace kinora::fields
