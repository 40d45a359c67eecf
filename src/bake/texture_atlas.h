// A surface cut into charts that lie flat beside one another in one picture.
// Source: Lévy, Petitjean, Ray, Maillot, "Least Squares Conformal Maps for Automatic Texture Atlas Generation", ACM TOG
// 21(3), 2002, sec. 3 (growing and packing charts); each chart is simply projected along its mean normal.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "bake/surface_nets.h"
#include "core/progress.h"

namespace kinora::bake {

/// Where each corner of a surface is in its picture. Vertices on the edges between charts are there once for each.
struct TextureAtlas {
  int width = 0;
  int height = 0;                                  ///< pixels; multiples of 4
  std::vector<std::uint32_t> sources;              ///< per vertex, the surface's vertex that it is
  std::vector<Eigen::Vector2f> coordinates;        ///< per vertex, pixels from the picture's upper left corner
  std::vector<std::array<std::uint32_t, 3>> faces; ///< as the surface's, of the vertices here
};

/// Charts do not overlap, and lie two pixels apart. A pixel is `pixel` metres wide, or more so that no side is longer
/// than `max_side` pixels. Same bits every time. Throws Error: kFailure if the surface has more charts than fit at any
/// scale, kInterrupted.
TextureAtlas texture_atlas(const Triangles& triangles, double pixel, int max_side, const Progress& progress);

} // namespace kinora::bake
