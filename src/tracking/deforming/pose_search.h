// Where a layer may have gone when it is not near its predicted place: shifts over the whole view, judged by depth and
// brightness, then rigid alignment of the most promising.
#pragma once

#include <span>
#include <vector>

#include "tracking/deforming/deforming_alignment.h"

namespace kinora::tracking {

struct PoseSearchConfig {
  int shifts = 80;                   ///< that are tried across the longer side of the view
  std::size_t max_points = 300;      ///< model points that judge a shift
  std::size_t candidates = 8;        ///< shifts that are refined
  double depth_tolerance = 0.03;     ///< metres, where a point's depth counts as wrong
  double brightness_tolerance = 0.3; ///< of the log luminance, where a point's brightness counts as wrong
};

/// The states moved to the best place found; nothing wider than a rigid motion. In [0, 1], `cost` tells how much of
/// the model the view contradicts there.
struct PoseSearchResult {
  motion::NodeStates states;
  double cost = 1;
};

/// `start`: canonical to camera. Deterministic. With no point or nothing measured the result is the start, at cost 1.
PoseSearchResult search_pose(const LayerModel& model, std::span<const PointTexture> textures, const LayerView& view,
                             const motion::NodeStates& start, const PoseSearchConfig& config = {});

/// How much of the model the view contradicts at `states`: mean over the points of half a wrong depth and half a wrong
/// brightness; a point that falls where nothing of the layer is measured is all wrong.
double alignment_cost(const LayerModel& model, std::span<const PointTexture> textures, const LayerView& view,
                      const motion::NodeStates& states, const PoseSearchConfig& config = {});

} // namespace kinora::tracking
