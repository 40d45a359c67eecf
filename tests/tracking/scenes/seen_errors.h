// How far the points of a motion are from where they truly are, while they are seen.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "evaluate/ground_truth_tracks.h"
#include "motion/motion.h"
#include "motion/point_track.h"

namespace kinora::tracking::testing {

/// Metres, means over points and frames; infinite if a place is no number.
struct SeenErrors {
  double mean = 0; ///< of points that are seen, each tracked from where it is seen first
  double seam = 0; ///< of these, in the last frame of points that are seen in the first as well
};

/// `numbers`: for each frame of the motion, which one of the truth it is; −1: none.
inline SeenErrors seen_errors(const evaluate::GroundTruthTracks& truth, const motion::Motion& motion,
                              const std::vector<int>& numbers) {
  SeenErrors errors;
  double count = 0;
  double at_both_ends = 0;
  for (const auto& track_of_id : truth) {
    const auto seen_at = [&](int number) {
      const auto found = track_of_id.second.find(number);
      return found != track_of_id.second.end() && found->second.visible ? &found->second.point : nullptr;
    };
    const auto first = std::ranges::find_if(numbers, seen_at);
    if (first == numbers.end()) continue;
    const auto start = static_cast<std::size_t>(first - numbers.begin());
    const auto track = motion::track_point(motion, numbers.size(), start, *seen_at(*first));
    for (std::size_t i = start; i < numbers.size(); ++i) {
      const Eigen::Vector3d* position = seen_at(numbers[i]);
      if (position == nullptr) continue;
      const double distance = (track[i] - *position).norm();
      const double error = std::isfinite(distance) ? distance : std::numeric_limits<double>::infinity();
      errors.mean += error;
      ++count;
      if (start > 0 || i + 1 < numbers.size()) continue;
      errors.seam += error;
      ++at_both_ends;
    }
  }
  errors.mean /= count;
  errors.seam /= at_both_ends;
  return errors;
}

} // namespace kinora::tracking::testing
