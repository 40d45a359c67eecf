// Which points of a surface become nodes of the deformation graph.
// Source: Sumner et al., "Embedded Deformation", SIGGRAPH 2007.
#pragma once

#include <span>
#include <vector>

#include "tracking/tsdf/tsdf.h"

namespace kinora::tracking {

/// An oriented point of a thinned surface, relative to the layer's origin, metres.
struct SurfaceSample {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;
};

/// One point for each cell of a grid that the surface meets: the heaviest, in the order of the surface.
std::vector<SurfaceSample> downsample_surface(std::span<const SurfacePoint> surface, double cell, float min_weight);

/// Samples that lie farther than `spacing` from every node so far, taken in order, as further nodes; at most up to
/// `limit` nodes in all. Nodes so far stay the first.
void add_nodes(std::span<const SurfaceSample> samples, double spacing, std::size_t limit,
               std::vector<Eigen::Vector3d>& nodes);

} // namespace kinora::tracking
