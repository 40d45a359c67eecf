// Where a measured ray's surface is, told by the field itself once it has learnt from many views.
#pragma once

#include <vector>

#include "fields/field.h"
#include "fields/field_batch.h"
#include "fields/ray_batch.h"

namespace kinora::fields {

/// Kept from chunk to chunk.
struct RefinementScratch {
  std::vector<float> x, y, z, length, density, transmittance; ///< of the samples in the bands of measured rays
  PointBatch points;
};

/// The field so far is the fused surface, and a measurement one noisy look at it. The densities at an own ray's samples
/// in the band about its measured depth (the last ones of the ray) give the depth at which the field is met there. Where
/// the band holds most of a surface, kRefinedSamples samples in half as wide a band about a place between both replace
/// these, and the target's depth moves a part of the way. Elsewhere the ray stays as it is.
void refine_rays(const Field& field, std::span<const GridLevel> levels, RayBatch& rays, RefinementScratch& scratch);

inline constexpr std::size_t kRefinedSamples = 3;

} // namespace kinora::fields
