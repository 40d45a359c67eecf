#include "motion/node_births.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kinora::motion {

namespace {

/// Of all weights, which add up to 1.
constexpr double kMaxUnborn = 0.5;

} // namespace

bool is_unborn(const Influence& influence, const UnbornNodes& unborn) {
  if (unborn.empty()) return false;
  double weight = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
    if (unborn[static_cast<std::size_t>(influence.nodes[k])]) weight += influence.weights[k];
  }
  return weight > kMaxUnborn;
}

NodeBirths::NodeBirths(std::vector<std::uint32_t> frames) {
  if (std::any_of(frames.begin(), frames.end(), [](std::uint32_t frame) { return frame > 0; }))
    frames_ = std::move(frames);
}

UnbornNodes NodeBirths::unborn(double frame) const {
  const double whole = std::floor(frame);
  const auto is_later = [whole](std::uint32_t birth) { return static_cast<double>(birth) > whole; };
  if (std::none_of(frames_.begin(), frames_.end(), is_later)) return {};
  UnbornNodes unborn(frames_.size());
  std::transform(frames_.begin(), frames_.end(), unborn.begin(), is_later);
  return unborn;
}

NodeBirths NodeBirths::in_first_frames(std::uint32_t count) const {
  std::vector<std::uint32_t> frames = frames_;
  for (std::uint32_t& frame : frames) frame = std::min(frame, count);
  return NodeBirths(std::move(frames));
}

std::uint32_t NodeBirths::birth_of(const Influence& influence) const {
  if (frames_.empty() || influence.count == 0) return 0;
  const auto count = static_cast<std::size_t>(influence.count);
  std::array<std::size_t, Influence::kMax> order{};
  for (std::size_t k = 0; k < count; ++k) order[k] = k;
  const auto birth = [&](std::size_t k) { return frames_[static_cast<std::size_t>(influence.nodes[k])]; };
  // From the last born on, as long as those that are born later weigh no more than they may.
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
            [&](std::size_t a, std::size_t b) { return birth(a) > birth(b); });
  double later = 0;
  for (std::size_t i = 0; i < count; ++i) {
    later += influence.weights[order[i]];
    if (later > kMaxUnborn) return birth(order[i]);
  }
  return birth(order[count - 1]);
}

} // namespace kinora::motion
