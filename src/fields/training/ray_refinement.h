// Where a measured ray's surface is, told by the field itself once it has learnt from many views.
#pragma once

#include <vector>

#include "fields/model/field.h"
#include "fields/network/field_batch.h"
#include "fields/network/ray_batch.h"

namespace kinora::fields {

inline constexpr std::size_t kRefinedSamples = 3;

/// Kept from chunk to chunk.
struct RefinementScratch {
  std::vector<float> x, y, z, length, density, step_transmittance; ///< of the samples in the bands of measured rays
  PointBatch points;
};

/// The field so far is the fused surface, and a measurement one noisy look at it. The densities at an own ray's samples
/// in the band about its measured depth (the last ones of the ray) say at which depth the field is met there:
/// - Where they hold most of a surface, kRefinedSamples samples replace them, in half as wide a band about a place
///   between both, and the target's depth moves a part of the way.
/// - Where they are empty, the measurement is wrong (between two surfaces, or beside an edge): the ray is taken out, so
///   that its colour goes nowhere either.
/// - Between that the ray stays as it is.
void refine_rays(const Field& field, std::span<const GridLevel> levels, RayBatch& rays, RefinementScratch& scratch);

} // namespace kinora::fields
