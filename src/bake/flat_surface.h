// Layers that are flat as a whole: floors and walls.
#pragma once

#include "bake/surface_nets.h"
#include "fields/model/confidence.h"

namespace kinora::bake {

/// Whether all of the surface, but for a thousandth of its vertices, is within `height` metres of its mean plane.
bool is_flat(const Triangles& triangles, double height);

/// Moves vertices of sides that no camera of the capture saw, and that are some cells away from what one saw, to the
/// means of their neighbours, over and over, up to 5 cm far: there the surface is where the stored occupancy happens to
/// end, in steps of its cells. Same bits every time.
void smooth_unseen(const fields::FieldBox& box, const fields::Confidence& confidence, Triangles& triangles);

} // namespace kinora::bake
