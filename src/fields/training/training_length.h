// How long a training goes on: as long as what it gains is worth what it costs.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "fields/model/field.h"

namespace kinora::fields {

/// Seconds of one processor of the machine in docs/experiments/exchange.md that a training with this field takes for a
/// sample: a table, not a clock, so that the same input gives the same field on every machine.
double seconds_per_sample(const FieldConfig& config);

/// What a training must gain to go on.
struct ExchangeRate {
  /// dB over the rays held apart, of mean squared errors to which `invisible` is added, for another second of a
  /// processor (seconds_per_sample). 0: nothing is asked, and all rays are trained.
  double decibels_per_second = 0;
  double invisible = 6e-4;        ///< of ‖C − C*‖²: 3.6 steps of 255 in each channel
  std::size_t min_rays = 200'000; ///< before which nothing is decided
};

/// Error over the rays held apart, at some time of a training.
struct TrainingLook {
  std::size_t rays = 0; ///< trained so far
  double error = 0;     ///< mean of ‖C − C*‖²
};

/// What half as much training again is expected to bring.
struct TrainingOutlook {
  std::size_t rays = 0; ///< more than are trained
  double decibels = 0;  ///< as ExchangeRate counts them
  double seconds = 0;   ///< of a processor
};

enum class LengthVerdict {
  kAsked,      ///< as long as it was asked to be
  kNotJudged,  ///< too few rays are held apart to tell what is gained
  kEnough,     ///< more would gain too little for its time
  kAllAllowed, ///< more would pay, and is not allowed
};
/// One clause for the report.
std::string_view reason_of(LengthVerdict verdict);

/// The first half of a training has constant steps, so that until then it may be made longer. Whenever its half is
/// reached, the slope of the error over the logarithm of the rays tells what more would gain.
class TrainingLength {
public:
  /// `can_judge`: whether enough rays are held apart.
  TrainingLength(const ExchangeRate& rate, std::size_t max_rays, bool can_judge);

  /// Of the whole training, as it is planned now.
  std::size_t rays() const { return rays_; }
  /// Whether it may still become longer.
  bool is_open() const { return is_open_; }
  /// Rays after which it is to be told the next error; while it is open.
  std::size_t next_look() const;
  /// Tells it; makes the training longer or ends its growing. `seconds_per_ray`: of a processor.
  void look(const TrainingLook& look, double seconds_per_ray);
  /// What was seen so far was another field's: one that has collapsed, or has smaller tables.
  void forget();
  /// Begins anew with another field.
  void restart();

  LengthVerdict verdict() const { return verdict_; }
  const std::vector<TrainingLook>& looks() const { return looks_; }
  const TrainingOutlook& outlook() const { return outlook_; }

private:
  double decibels_per_doubling() const;

  ExchangeRate rate_;
  std::size_t max_rays_;
  std::size_t rays_;
  bool is_open_;
  LengthVerdict verdict_;
  std::vector<TrainingLook> looks_; // all
  std::size_t first_look_ = 0;      // of those that count
  TrainingOutlook outlook_;
};

} // namespace kinora::fields
