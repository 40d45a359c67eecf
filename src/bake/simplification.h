// Fewer triangles where the surface is flat.
// Source: Garland, Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997, as meshoptimizer has
// it.
#pragma once

#include <span>
#include <vector>

#include "bake/surface_nets.h"

namespace kinora::bake {

/// Joins edges until the surface would be off by `max_error` metres, or `min_faces` are left. The vertices that stay
/// are some of those given. Same bits every time.
void simplify(Triangles& triangles, double max_error, std::size_t min_faces);

} // namespace kinora::bake
