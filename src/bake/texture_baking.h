// The picture on a surface, from its field.
#pragma once

#include <span>

#include "bake/surface_colors.h"
#include "bake/texture_atlas.h"
#include "core/image.h"

namespace kinora::bake {

/// Colours (3 channels, sRGB) of all pixels that show the surface; those around take the mean of their neighbours, so
/// that charts do not fray, and the rest the mean of all. `normals`: of the surface's vertices. `before`: how far the
/// triangles may lie behind the field's own surface, metres. Throws Error(kInterrupted).
ColorImage bake_texture(const TextureAtlas& atlas, const Triangles& triangles, std::span<const Eigen::Vector3d> normals,
                        const FieldSampler& sampler, const motion::Motion& motion, double before,
                        const Progress& progress);

} // namespace kinora::bake
