// Where a field becomes opaque, as triangles.
// Source: Gibson, "Constrained Elastic Surface Nets", MICCAI 1998, without the relaxation: a vertex in each cell that
// the surface passes, at the mean of where it crosses the cell's edges.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "bake/field_sampler.h"
#include "core/progress.h"

namespace kinora::bake {

struct Triangles {
  std::vector<Eigen::Vector3d> positions;          ///< canonical, metres
  std::vector<std::array<std::uint32_t, 3>> faces; ///< counterclockwise seen from outside
};

/// The surface at which the field's density (extinction per metre) passes `level`, on a grid of `resolution` cells per
/// side of the field's box. Closed, also at the box and at the end of the stored occupancy. Uses all threads; same
/// bits for any number of them. Throws Error(kInterrupted) when cancelled.
Triangles surface_nets(const FieldSampler& sampler, double level, int resolution, const Progress& progress);

/// Leaves out vertices for which `keep` is 0, and the faces that have one of them or are left without.
void keep_vertices(Triangles& triangles, const std::vector<std::uint8_t>& keep);

/// Leaves out connected parts with less than `share` of the faces of the largest one.
void remove_small_components(Triangles& triangles, double share);

/// Per vertex, the mean of the normals of its faces, weighted by their areas; unit length.
std::vector<Eigen::Vector3d> vertex_normals(const Triangles& triangles);

} // namespace kinora::bake
