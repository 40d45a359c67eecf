// Where something was at an instant at which nobody looked, on a smooth path through where it was before and after.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/se3.h"

namespace kinora::encode {

/// Frames beside an instant, the nearest one before it (or, before all, the first) in front, and what each weighs in
/// the polynomial through them (Lagrange); weights add up to one.
struct PathSupport {
  std::vector<std::size_t> frames;
  std::vector<double> weights;
};

/// Two frames before and two after `time`, fewer at the ends of the timeline: beyond an end it goes on as between the
/// last two. `times`: of the frames, in seconds, increasing, at least one. Farther ones are used only if all that are
/// used are `tracked`.
PathSupport path_support(std::span<const double> times, double time,
                         const std::function<bool(std::size_t frame)>& tracked);

/// The pose on the polynomial through `poses` (one for each weight) in the tangent space of the first: with two of
/// them the same as interpolate().
SE3 pose_on_path(std::span<const SE3> poses, std::span<const double> weights);

} // namespace kinora::encode
