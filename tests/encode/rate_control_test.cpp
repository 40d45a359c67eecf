#include "encode/rate_control.h"

#include <cmath>

#include <gtest/gtest.h>

#include "clip/clip_io.h"
#include "clip/sample_clip.h"
#include "container/ebml_builder.h"
#include "fields/scenes/painted_field.h"
#include "player/player.h"
#include "support/source_folder.h"

namespace kinora::encode {
namespace {

class RateControlTest : public testing::Test {
protected:
  static clip::Clip load() {
    return clip::read_clip(test::source_folder() / "tests" / "conformance" / "clip_fields_3_and_4.mkv");
  }
  /// Of the file, with these steps.
  std::size_t stored(const clip::Clip& clip, const clip::StorageOptions& options = {}) const {
    clip::write_clip(clip, folder_ / "a.mkv", options);
    return static_cast<std::size_t>(std::filesystem::file_size(folder_ / "a.mkv"));
  }
  /// Squared, of all parameters that are stored.
  double error_of(const clip::Clip& clip) const {
    const clip::Clip back = clip::read_clip(folder_ / "a.mkv");
    double error = 0;
    for (std::size_t l = 0; l < clip.layers.size(); ++l) {
      const auto& before = clip.layers[l].field.table;
      for (std::size_t i = 0; i < before.size(); ++i) error += std::pow(before[i] - back.layers[l].field.table[i], 2);
    }
    return error;
  }
  /// Of what the capture's camera sees of one and the other, over all that the first shows, in the middle of it.
  static double picture_psnr(const clip::Clip& truth, const clip::Clip& other) {
    const std::size_t middle = truth.times.size() / 2;
    const auto frame = static_cast<double>(middle);
    const auto draw = [frame](const clip::Clip& clip) {
      const player::Player player(clip);
      return player.draw(clip.capture_camera(frame), frame, player.all_layers()).color;
    };
    const ColorImage a = draw(truth);
    const ColorImage b = draw(other);
    double error = 0;
    double count = 0;
    for (std::size_t i = 0; i < a.pixel_count(); ++i) {
      if (a.data()[4 * i + 3] <= 127) continue;
      for (std::size_t c = 0; c < 3; ++c) error += std::pow(a.data()[4 * i + c] - b.data()[4 * i + c], 2);
      count += 3;
    }
    return 10 * std::log10(255 * 255 * count / error);
  }
  /// A wavy ball before a camera that stands still.
  static clip::Clip painted() {
    clip::Clip clip = clip::testing::sample_clip(1, 3, false);
    clip.layers.resize(1);
    clip.camera_to_world = {SE3(Eigen::Translation3d(0, 0, -1.2))};
    const auto shape = [](const Eigen::Vector3d& p) {
      const Eigen::Vector3d waves = (40 * p).array().sin();
      return fields::testing::Paint{p.norm() - 0.3, (0.5 + 0.3 * waves.array()).matrix()};
    };
    clip.layers[0].field = fields::testing::painted_field({{-0.5, -0.5, -0.5}, 1}, shape, 1);
    clip.layers[0].confidence.reset();
    return clip;
  }
  container::testing::TemporaryFolder folder_;
  Progress silent_;
};

TEST_F(RateControlTest, FilesTakeWhatTheyMayAndMoreIsBetter) {
  const clip::Clip clip = load();
  const RateControl control(clip, stored(clip), silent_);
  const auto fewest = static_cast<double>(control.fewest_bytes());
  const auto most = static_cast<double>(control.most_bytes());
  ASSERT_LT(fewest, most);
  double last_error = HUGE_VAL;
  double last_psnr = 0;
  for (const double share : {0.2, 0.4, 0.6, 0.8, 1.0}) {
    const double wanted = fewest + share * (most - fewest);
    const RateChoice choice = control.for_bytes(static_cast<std::size_t>(wanted));
    const auto bytes = static_cast<double>(stored(clip, {choice.fields}));
    EXPECT_NEAR(bytes, static_cast<double>(choice.bytes), 0.002 * wanted) << share;
    EXPECT_NEAR(bytes, wanted, 0.05 * wanted) << share;
    const double error = error_of(clip);
    EXPECT_LT(error, last_error) << share;
    EXPECT_GT(choice.picture_psnr, last_psnr) << share;
    last_error = error;
    last_psnr = choice.picture_psnr;
  }
}

// Finer steps lose nothing of it; coarser ones do.
TEST_F(RateControlTest, AClipOfCoarseStepsTakesWhatItMayToo) {
  clip::Clip clip = load();
  for (clip::Layer& layer : clip.layers) {
    clip::FieldRounding rounding = clip::usual_rounding(layer.field.config);
    for (clip::Rounding& level : rounding) level = {level.steps_per_rms / 2, level.up_from, true};
    layer.field = clip::rounded(layer.field, rounding).field;
  }
  const std::size_t usual = stored(clip);
  EXPECT_EQ(error_of(clip), 0);
  const RateControl control(clip, usual, silent_);
  EXPECT_NEAR(static_cast<double>(control.most_bytes()), static_cast<double>(usual),
              0.002 * static_cast<double>(usual));
  const auto fewest = static_cast<double>(control.fewest_bytes());
  const auto most = static_cast<double>(control.most_bytes());
  double last_error = HUGE_VAL;
  for (const double share : {0.2, 0.4, 0.6, 0.8, 1.0}) {
    const double wanted = fewest + share * (most - fewest);
    const RateChoice choice = control.for_bytes(static_cast<std::size_t>(wanted));
    EXPECT_NEAR(static_cast<double>(stored(clip, {choice.fields})), wanted, 0.05 * wanted) << share;
    const double error = error_of(clip);
    EXPECT_LT(error, last_error) << share;
    last_error = error;
  }
  EXPECT_EQ(last_error, 0);
}

TEST_F(RateControlTest, TakesTheCheapestWhereTheBytesAreTooFew) {
  const clip::Clip clip = load();
  const RateControl control(clip, stored(clip), silent_);
  const RateChoice choice = control.for_bytes(1);
  EXPECT_EQ(choice.bytes, control.fewest_bytes());
  EXPECT_LT(stored(clip, {choice.fields}), stored(clip));
}

// The estimate takes errors to grow with those of one rounding.
TEST_F(RateControlTest, PicturesAreAsGoodAsIsEstimated) {
  const clip::Clip clip = painted();
  const RateControl control(clip, stored(clip), silent_);
  const auto fewest = static_cast<double>(control.fewest_bytes());
  const auto most = static_cast<double>(control.most_bytes());
  for (const double share : {0.6, 0.75, 0.9}) {
    const RateChoice choice = control.for_bytes(static_cast<std::size_t>(fewest + share * (most - fewest)));
    EXPECT_GT(choice.picture_psnr, 32) << share;
    stored(clip, {choice.fields});
    EXPECT_NEAR(picture_psnr(clip, clip::read_clip(folder_ / "a.mkv")), choice.picture_psnr, 3) << share;
  }
}

TEST_F(RateControlTest, WhatNoPictureShowsIsRoundedAsWhatTheyShow) {
  clip::Clip clip = painted();
  clip.layers.push_back(clip.layers[0]);
  clip.layers[1].name = "behind the camera";
  clip.layers[1].field.config.box.origin.z() -= 100;
  const RateControl control(clip, stored(clip), silent_);
  const std::size_t middle = (control.fewest_bytes() + control.most_bytes()) / 2;
  const std::vector<clip::FieldRounding> chosen = control.for_bytes(middle).fields;
  const auto error_of_layer = [&](std::size_t l) {
    const fields::Field& field = clip.layers[l].field;
    const fields::Field rounded = clip::rounded(field, chosen.at(l)).field;
    double error = 0;
    for (std::size_t i = 0; i < field.table.size(); ++i) error += std::pow(field.table[i] - rounded.table[i], 2);
    return error;
  };
  EXPECT_GT(error_of_layer(0), 0);
  EXPECT_LT(error_of_layer(1), 4 * error_of_layer(0));
}

TEST_F(RateControlTest, ChoosesTheSameAgain) {
  const clip::Clip clip = load();
  const std::size_t usual = stored(clip);
  const RateChoice choice = RateControl(clip, usual, silent_).for_bytes(usual);
  const RateChoice again = RateControl(clip, usual, silent_).for_bytes(usual);
  ASSERT_EQ(choice.bytes, again.bytes);
  stored(clip, {choice.fields});
  const double error = error_of(clip);
  stored(clip, {again.fields});
  EXPECT_EQ(error_of(clip), error);
}

} // namespace
} // namespace kinora::encode
