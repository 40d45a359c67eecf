// By how much depth comes later than colour.
#pragma once

#include <optional>
#include <vector>

#include "ingest/frame/frame.h"

namespace kinora::ingest {

/// Looks at frames one after another, some thousand pixels of each. Not thread-safe; the same bits for the same frames.
/// How much colour and how much depth changes from frame to frame are two signals; the delay is the shift at which they
/// correlate best, to a fraction of a frame by a parabola. It is told only if the signals vary and agree. What
/// brightness changes as a whole, by automatic exposure, is no change: the median log ratio of pixels that keep their
/// depth, against a reference that is renewed when too few pixels are left in common.
class StreamDelay {
public:
  void add(const Frame& frame);
  /// Seconds by which depth shows things later than colour; nothing: it cannot be told.
  std::optional<double> seconds() const;

private:
  struct Sample {
    std::vector<std::optional<float>> brightness; ///< linear, of 0…1; nothing: too dark or too bright to tell
    std::vector<float> depth;
  };
  static Sample sample_of(const Frame& frame);
  std::optional<double> gain_against(const Sample& sample, const Sample& reference) const;

  Sample reference_;
  double reference_gain_ = 1; ///< of brightness, relative to the first frame
  Sample last_;
  double last_gain_ = 1;
  std::vector<double> times_;
  std::vector<double> color_motion_;
  std::vector<double> depth_motion_;
};

} // namespace kinora::ingest
