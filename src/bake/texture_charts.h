// Parts of a surface that can be laid flat without overlapping.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "bake/surface_nets.h"
#include "core/progress.h"

namespace kinora::bake {

/// Connected faces, and where their corners are when they are projected along the chart's mean normal.
struct Chart {
  std::vector<std::uint32_t> faces;                    ///< of the surface
  std::vector<std::array<Eigen::Vector2d, 3>> corners; ///< per face, metres, from the lower corner of the bounding box
  Eigen::Vector2d size = Eigen::Vector2d::Zero();      ///< of the bounding box, metres; wider than high
};

/// Every face is in one chart. Two faces of a chart do not overlap, seen at `pixel` metres.
std::vector<Chart> texture_charts(const Triangles& triangles, double pixel, const Progress& progress);

} // namespace kinora::bake
