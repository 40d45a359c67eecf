// Damped Gauss–Newton (Levenberg–Marquardt): a step that solves the linearised problem is taken if it pays, and the
// next one is damped less; if it does not pay, the next one is damped more, which makes it shorter. Sources: Marquardt,
// "An Algorithm for Least-Squares Estimation of Nonlinear Parameters", 1963; Nielsen, "Damping Parameter in Marquardt's
// Method", 1999.
#pragma once

#include <algorithm>
#include <cmath>

namespace kinora {

/// What has become of a step.
struct StepOutcome {
  bool is_taken = false;
  bool is_last = false;  ///< no other is wanted, whether this one was taken or not
  double gain_ratio = 1; ///< what a step that was taken has saved, over what the linearised problem promised
};

/// Damping by constant factors.
class MarquardtDamping {
public:
  struct Config {
    double first = 1e-3;
    double min = 1e-6;
    double max = 1e3;     ///< with more, no step is tried
    double shrinkage = 5; ///< after a step that is taken, by this factor
    double growth = 10;   ///< after one that is not
    double min_after_refusal = 0;
  };
  explicit MarquardtDamping(const Config& config) : config_(config), value_(config.first) {}

  double value() const { return value_; }
  bool is_exhausted() const { return value_ > config_.max; }
  void accept(double /*gain_ratio*/) { value_ = std::max(config_.min, value_ / config_.shrinkage); }
  void refuse() { value_ = std::max(config_.min_after_refusal, config_.growth * value_); }

private:
  Config config_;
  double value_;
};

/// Damping by what steps gain: it falls fast where the linearised problem tells the truth, and rises ever faster where
/// steps are refused.
class NielsenDamping {
public:
  double value() const { return value_; }
  bool is_exhausted() const { return false; }
  void accept(double gain_ratio) {
    const double factor = 1 - std::pow(2 * std::min(gain_ratio, 1.0) - 1, 3);
    value_ = std::clamp(value_ * std::max(1.0 / 3, factor), kMin, kMax);
    growth_ = 2;
  }
  void refuse() {
    value_ = std::min(value_ * growth_, kMax);
    growth_ *= 2;
  }

private:
  static constexpr double kMin = 1e-6;
  static constexpr double kMax = 1e3;
  double value_ = 1e-3;
  double growth_ = 2;
};

/// Tries at most so many steps. `attempt(damping)` solves for one, takes it or not, linearises anew if it likes, and
/// returns a StepOutcome. Returns whether the last step was taken.
template <class Damping, class Attempt>
bool damped_gauss_newton(Damping& damping, int attempts, const Attempt& attempt) {
  StepOutcome outcome;
  for (int i = 0; i < attempts && !outcome.is_last && !damping.is_exhausted(); ++i) {
    outcome = attempt(damping.value());
    if (outcome.is_taken) {
      damping.accept(outcome.gain_ratio);
    } else {
      damping.refuse();
    }
  }
  return outcome.is_taken;
}

} // namespace kinora
