#include "player/window/moving_resolution.h"

#include <algorithm>
#include <cmath>

namespace kinora::player::window {

void MovingResolution::took(double milliseconds) {
  const bool is_soon = milliseconds <= kMostOfWanted * kWantedMilliseconds;
  const bool is_large = scale_ == kLargest || milliseconds >= kLeastOfWanted * kWantedMilliseconds;
  if (is_soon && is_large) return;
  const double fitting = scale_ * std::sqrt(kWantedMilliseconds / std::max(milliseconds, 1.0));
  scale_ = std::clamp(std::sqrt(scale_ * fitting), kSmallest, kLargest);
}

} // namespace kinora::player::window
