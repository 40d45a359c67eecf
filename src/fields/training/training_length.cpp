#include "fields/training/training_length.h"

#include <algorithm>
#include <cmath>

namespace kinora::fields {
namespace {

constexpr double kStep = 1.4142135623730951; // from one length to the next that is thought of
constexpr std::size_t kFewestLooks = 4;      // that tell a slope
constexpr std::size_t kMostLooks = 5;        // older ones tell what is past

std::size_t longer(std::size_t rays, std::size_t most) {
  return std::min(most, static_cast<std::size_t>(kStep * static_cast<double>(rays)));
}

} // namespace

double seconds_per_sample(const FieldConfig& config) {
  const double levels = 1e-7 * (1 + 0.85 * config.levels);
  return levels * (1 + 0.1 * std::max(0, config.log2_table_size - 14)); // larger ones leave the nearer caches
}

std::string_view reason_of(LengthVerdict verdict) {
  switch (verdict) {
  case LengthVerdict::kAsked:
    return "so many were asked for";
  case LengthVerdict::kNotJudged:
    return "too few rays are held apart to tell what more would gain";
  case LengthVerdict::kEnough:
    return "more would gain too little for its time";
  case LengthVerdict::kAllAllowed:
    break;
  }
  return "more would pay, but its pixels have been looked at often enough";
}

TrainingLength::TrainingLength(const ExchangeRate& rate, std::size_t max_rays, bool can_judge)
    : rate_(rate), max_rays_(std::max<std::size_t>(max_rays, 1)), rays_(max_rays_),
      is_open_(rate.decibels_per_second > 0 && can_judge),
      verdict_(rate.decibels_per_second > 0 && !can_judge ? LengthVerdict::kNotJudged : LengthVerdict::kAsked) {
  if (rate.decibels_per_second > 0) restart();
}

void TrainingLength::restart() {
  if (rate_.decibels_per_second <= 0) return;
  rays_ = std::min(rate_.min_rays, max_rays_);
  is_open_ = verdict_ != LengthVerdict::kNotJudged && rays_ < max_rays_;
  if (verdict_ != LengthVerdict::kNotJudged) verdict_ = LengthVerdict::kAllAllowed;
  outlook_ = {};
  looks_.clear();
  first_look_ = 0;
}

void TrainingLength::forget() { first_look_ = looks_.size(); }

std::size_t TrainingLength::next_look() const { return rays_ / 2; }

void TrainingLength::look(const TrainingLook& look, double seconds_per_ray) {
  looks_.push_back(look);
  if (looks_.size() - first_look_ >= kFewestLooks) {
    const double more = kStep - 1;
    outlook_.rays = static_cast<std::size_t>(more * static_cast<double>(rays_));
    outlook_.decibels = std::max(0.0, decibels_per_doubling()) * std::log2(kStep);
    outlook_.seconds = seconds_per_ray * static_cast<double>(outlook_.rays);
    if (outlook_.decibels < rate_.decibels_per_second * outlook_.seconds) {
      verdict_ = LengthVerdict::kEnough;
      is_open_ = false;
      return;
    }
  }
  rays_ = longer(rays_, max_rays_);
  is_open_ = rays_ < max_rays_;
}

// A line through the last looks, by least squares.
double TrainingLength::decibels_per_doubling() const {
  const std::size_t begin = std::max(first_look_, looks_.size() - std::min(kMostLooks, looks_.size()));
  const auto count = static_cast<double>(looks_.size() - begin);
  double x_mean = 0;
  double y_mean = 0;
  const auto x_of = [](const TrainingLook& look) { return std::log2(static_cast<double>(look.rays)); };
  const auto y_of = [&](const TrainingLook& look) { return -10 * std::log10(look.error + rate_.invisible); };
  for (std::size_t i = begin; i < looks_.size(); ++i) {
    x_mean += x_of(looks_[i]) / count;
    y_mean += y_of(looks_[i]) / count;
  }
  double xy = 0;
  double xx = 0;
  for (std::size_t i = begin; i < looks_.size(); ++i) {
    const double x = x_of(looks_[i]) - x_mean;
    xy += x * (y_of(looks_[i]) - y_mean);
    xx += x * x;
  }
  return xx > 0 ? xy / xx : 0;
}

} // namespace kinora::fields
