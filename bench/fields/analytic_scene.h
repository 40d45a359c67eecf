// The scene of the measured limit: a textured sphere, a box and a slab, seen from all around, with known depth.
#pragma once

#include <vector>

#include "ingest/frame/frame.h"

namespace kinora::bench {

struct AnalyticScene {
  // What is wrong with the trained views' depth; the scene is 1 m wide.
  double noise = 0; ///< standard deviation, metres
  double bias = 0;  ///< metres too far
  int shift = 0;    ///< pixels that depth lies to the left of colour

  static constexpr int kSide = 256;        ///< pixels
  static constexpr int kTrainedViews = 30; ///< on a spiral from 10° to 65° above the slab
  static constexpr int kHeldOutViews = 3;

  ingest::Frame trained_view(int index) const;
  ingest::Frame held_out_view(int index) const;
};

} // namespace kinora::bench
