// What changes in the streams that is not the scene: automatic exposure, and a delay between colour and depth.
#pragma once

#include <optional>
#include <vector>

#include "ingest/frame/frame.h"

namespace kinora::ingest {

struct StreamReport {
  std::vector<double> gains; ///< per added frame: linear brightness relative to the first, 1 where it cannot be told
  bool exposure_changes = false;     ///< some gain differs from 1 by more than 3 %
  std::optional<double> time_offset; ///< seconds by which depth shows things later than colour; nothing: cannot be told
};

/// Looks at frames one after another, some thousand pixels of each. Not thread-safe; the same bits for the same frames.
/// Gain: the median log ratio of the linear brightness of pixels that keep their depth, against a reference whose gain
/// is known; the reference is renewed when too few pixels are left in common.
/// Time offset: how much colour and how much depth changes from frame to frame are two signals; the shift at which
/// they correlate best, to a fraction of a frame by a parabola. It is told only if the signals vary and agree.
class StreamEstimates {
public:
  void add(const Frame& frame);
  StreamReport report() const;

private:
  struct Sample {
    std::vector<std::optional<float>> brightness; ///< linear, of 0…1; nothing: too dark or too bright to tell
    std::vector<float> depth;
  };
  static Sample sample_of(const Frame& frame);
  std::optional<double> gain_against(const Sample& sample, const Sample& reference) const;

  Sample reference_;
  double reference_gain_ = 1;
  Sample last_;
  std::vector<double> gains_;
  std::vector<double> times_;
  std::vector<double> color_motion_;
  std::vector<double> depth_motion_;
};

} // namespace kinora::ingest
