// Which points of a deforming layer's surface take part in aligning it to a view, and what they look like.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "tracking/deforming/deforming_alignment.h"
#include "tracking/tsdf/tsdf.h"

namespace kinora::tracking {

struct DeformingSelection {
  std::vector<motion::SkinnedPoint> points;
  std::vector<PointTexture> textures; ///< the fused ones; of the last view once it is told

  /// Adds what `view`, another frame's, shows of each point, of which the nodes' `states` there say where it is.
  void add_last_view(const LayerView& view, const motion::NodeStates& states);
};

/// Points that face the camera and fall into the crop, evenly drawn from the order of the surface, at most
/// `max_points`. `skin`: one for each point. `takes_part`: of the nodes that carry a point; empty: all. Same bits for
/// any number of threads.
DeformingSelection select_facing(std::span<const SurfacePoint> surface, std::span<const motion::Influence> skin,
                                 const LayerView& view, const motion::NodeStates& states, std::size_t max_points,
                                 const std::function<bool(const motion::Influence&)>& takes_part = {});

} // namespace kinora::tracking
