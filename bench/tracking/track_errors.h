// How far the points of a motion are from where they truly are.
#pragma once

#include <algorithm>
#include <cstdio>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "evaluate/ground_truth_tracks.h"
#include "follow_label.h"
#include "ingest/frame/frame.h"
#include "motion/motion.h"
#include "motion/point_track.h"

namespace kinora::bench {

struct Errors {
  std::vector<double> values; ///< millimetres

  void add(const Eigen::Vector3d& estimated, const Eigen::Vector3d& truth) {
    values.push_back(estimated.allFinite() ? 1e3 * (estimated - truth).norm()
                                           : std::numeric_limits<double>::infinity());
  }
  double mean() const {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  }
  /// Mean, median and 95 %.
  std::string text() const {
    if (values.empty()) return ",,";
    return fmt::format("{:.2f},{:.2f},{:.2f}", mean(), at_fraction(values, 0.5), at_fraction(values, 0.95));
  }
};

/// Errors of a motion's points; what the capture's truth does not tell stays empty.
struct Comparison {
  Errors visible; ///< of tracks, each from its first visible frame, over all frames; or of scene flow
  Errors hidden;
};

/// `frames`: numbers that the truth has them by. `each`: prints every frame's.
inline Comparison compare_tracks(const evaluate::GroundTruthTracks& tracks, const motion::Motion& motion,
                                 const std::vector<int>& frames, bool each) {
  Comparison all;
  std::vector<Comparison> by_frame(frames.size());
  for (const auto& track_of_id : tracks) {
    const auto& positions = track_of_id.second;
    const auto first = std::find_if(frames.begin(), frames.end(), [&](int frame) {
      const auto found = positions.find(frame);
      return found != positions.end() && found->second.visible;
    });
    if (first == frames.end()) continue;
    const auto start = static_cast<std::size_t>(first - frames.begin());
    const auto track = motion::track_point(motion, frames.size(), start, positions.at(*first).point);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto truth = positions.find(frames[i]);
      if (truth == positions.end()) continue;
      (truth->second.visible ? all.visible : all.hidden).add(track[i], truth->second.point);
      (truth->second.visible ? by_frame[i].visible : by_frame[i].hidden).add(track[i], truth->second.point);
    }
  }
  for (std::size_t i = 0; each && i < frames.size(); ++i) {
    std::printf("# frame %d: seen points %s mm, hidden %s mm\n", frames[i], by_frame[i].visible.text().c_str(),
                by_frame[i].hidden.text().c_str());
  }
  return all;
}

} // namespace kinora::bench
