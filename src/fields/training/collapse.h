// Notices a training that will learn nothing more.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "fields/training/field_optimizer.h"

namespace kinora::fields {

/// Why a training is begun anew.
enum class Collapse : std::uint8_t {
  kNotFinite,   ///< the loss is
  kTransparent, ///< rays of the layer pass through it
  kOneColor     ///< the best single colour would explain what is seen as well
};

/// A half sentence for people.
constexpr const char* name_of(Collapse collapse) {
  switch (collapse) {
  case Collapse::kNotFinite:
    return "the loss is not finite";
  case Collapse::kTransparent:
    return "nothing is opaque";
  case Collapse::kOneColor:
    return "everything is of one colour";
  }
  return "";
}

/// Looks at one step after the other. Too large ones leave rectifiers that no gradient reaches any more, and every
/// number finite: the field gives up being opaque anywhere, or its colour is the same everywhere.
class CollapseDetector {
public:
  std::optional<Collapse> collapse(const StepResult& step) {
    constexpr std::size_t kFirstSteps = 200; // in which nothing can be expected yet
    constexpr double kMemory = 1.0 / 64;
    constexpr double kShare = 0.9;       // of the colours' variance that a field at least explains a tenth of
    constexpr double kNoContrast = 3e-3; // a variance that may be all noise: 8 of 255 in each channel
    constexpr double kOpaque = 0.02;
    if (!std::isfinite(step.loss)) return Collapse::kNotFinite;
    unexplained_ += kMemory * (step.color_error - kShare * step.color_variance - unexplained_);
    if (++steps_ <= kFirstSteps) return std::nullopt;
    if (step.opacity < kOpaque) return Collapse::kTransparent;
    if (unexplained_ > 0 && step.color_variance > kNoContrast) return Collapse::kOneColor;
    return std::nullopt;
  }

private:
  std::size_t steps_ = 0;
  double unexplained_ = 0; // mean of the last steps
};

} // namespace kinora::fields
