// Training goes on as long as it gains enough for its time, and no longer.
#include "fields/training/training_length.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "fields/scenes/analytic_scene.h"

namespace kinora::fields {
namespace {

constexpr double kSecondsPerRay = 2e-6;
constexpr std::size_t kMost = 1'000'000'000;

/// Errors that fall by `decibels` with each doubling, above `floor`, with noise.
struct Curve {
  double decibels;
  double floor = 0;
  double noise = 0; // dB
  std::uint64_t seed = 1;

  double at(std::size_t rays, std::size_t look) const {
    Random random(seed, look);
    const double db = decibels * std::log2(static_cast<double>(rays) / 1e5) + noise * (2 * random.uniform() - 1);
    return 0.1 * std::pow(10, -0.1 * db) + floor;
  }
};

TrainingLength trained_to_the_end(const Curve& curve, double price, std::size_t most = kMost) {
  ExchangeRate rate;
  rate.decibels_per_second = price;
  rate.invisible = 0;
  TrainingLength length(rate, most, true);
  while (length.is_open()) {
    const std::size_t rays = length.next_look();
    length.look({rays, curve.at(rays, length.looks().size())}, kSecondsPerRay);
  }
  return length;
}

// Where a doubling gains d decibels, one more ray gains d / (ln 2 · rays).
TEST(TrainingLength, EndsWhereTheNextRayCostsWhatItGains) {
  for (const double decibels : {0.2, 0.5, 1.0}) {
    for (const double price : {0.01, 0.05, 0.2}) {
      const double ideal = decibels / (std::log(2.0) * kSecondsPerRay * price);
      const TrainingLength length = trained_to_the_end({decibels}, price);
      if (ideal < 1e6) continue; // it is never shorter than what it takes to tell
      EXPECT_EQ(length.verdict(), LengthVerdict::kEnough);
      EXPECT_GT(static_cast<double>(length.rays()), 0.7 * ideal) << decibels << " dB at " << price;
      EXPECT_LT(static_cast<double>(length.rays()), 1.5 * ideal) << decibels << " dB at " << price;
      EXPECT_LT(length.outlook().decibels, price * length.outlook().seconds);
    }
  }
}

TEST(TrainingLength, ErrorsThatAreAllNoiseEndItSoon) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const TrainingLength length = trained_to_the_end({0, 0, 0.1, seed}, 0.05);
    EXPECT_EQ(length.verdict(), LengthVerdict::kEnough);
    EXPECT_LT(length.rays(), 4'000'000U) << seed;
  }
}

TEST(TrainingLength, WhatNobodySeesIsNotTrained) {
  ExchangeRate rate;
  rate.decibels_per_second = 0.05;
  const auto rays_with = [&](double invisible) {
    rate.invisible = invisible;
    TrainingLength length(rate, kMost, true);
    while (length.is_open()) length.look({length.next_look(), 600.0 / static_cast<double>(length.next_look())}, 2e-6);
    return length.rays();
  };
  EXPECT_GT(rays_with(0), 3 * rays_with(6e-4));
}

TEST(TrainingLength, IsNeverLongerThanAllowed) {
  const TrainingLength length = trained_to_the_end({1}, 1e-6, 3'000'000);
  EXPECT_EQ(length.rays(), 3'000'000U);
  EXPECT_EQ(length.verdict(), LengthVerdict::kAllAllowed);
  EXPECT_EQ(trained_to_the_end({1}, 1e-6, 20).rays(), 20U) << "a layer of few pixels";
}

TEST(TrainingLength, WithoutAPriceItIsWhatWasAskedFor) {
  const TrainingLength length({}, 7'000'000, true);
  EXPECT_FALSE(length.is_open());
  EXPECT_EQ(length.rays(), 7'000'000U);
  EXPECT_EQ(length.verdict(), LengthVerdict::kAsked);
}

TEST(TrainingLength, WithoutRaysToJudgeByItIsShort) {
  ExchangeRate rate;
  rate.decibels_per_second = 1e-6;
  TrainingLength length(rate, kMost, false);
  EXPECT_FALSE(length.is_open());
  EXPECT_EQ(length.rays(), rate.min_rays);
  EXPECT_EQ(length.verdict(), LengthVerdict::kNotJudged);
  length.restart();
  EXPECT_FALSE(length.is_open());
}

TEST(TrainingLength, AFieldThatBeginsAnewIsJudgedAnew) {
  ExchangeRate rate;
  rate.decibels_per_second = 0.05;
  TrainingLength length(rate, kMost, true);
  const std::size_t first = length.rays();
  for (int i = 0; i < 3; ++i) length.look({length.next_look(), 0.1}, kSecondsPerRay);
  EXPECT_GT(length.rays(), first);
  length.restart();
  EXPECT_EQ(length.rays(), first);
  EXPECT_TRUE(length.is_open());
  EXPECT_TRUE(length.looks().empty());
}

// Through the trainer: a scene that is learnt soon against the price of a second.
TEST(TrainingLength, ADearSecondMakesAShorterTraining) {
  PixelStore store(1'000'000, 8);
  const Scene scene;
  for (int i = 0; i < 8; ++i) store.add(scene.frame(i, 0.05 * (i - 4)), i);
  const auto still = motion::Motion::still();
  const LayerObservations layer{store, 0, still};
  Progress progress;
  std::size_t rays = 3'000'000;
  for (const double price : {0.5, 5.0}) {
    TrainerConfig trainer;
    trainer.rays = rays;
    trainer.exchange.decibels_per_second = price;
    TrainingReport report;
    train_field(layer, choose_field_config(layer), trainer, progress, &report);
    EXPECT_EQ(report.length, LengthVerdict::kEnough);
    EXPECT_LT(report.rays, rays);
    EXPECT_GE(report.looks.size(), 4U);
    EXPECT_LT(report.looks.back().error, report.looks.front().error);
    rays = report.rays;
  }
}

} // namespace
} // namespace kinora::fields
