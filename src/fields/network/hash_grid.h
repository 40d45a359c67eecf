// Multiresolution hash-grid encoding and its gradient.
// Source: Müller et al., "Instant Neural Graphics Primitives", ACM TOG 41(4), 2022, sec. 3.
// Vectorised with Highway and chosen at run time for the processor; reference.h says what it does, tests/fields keeps
// the two equal. Thread-safe as long as outputs do not overlap; the same bits for the same input on the same
// instruction set.
#pragma once

#include <cstddef>
#include <span>

#include "fields/model/field.h"

namespace kinora::fields::kernels {

/// Coordinates of n points in [0, 1]³, apart by axis; outside values are clamped.
struct Points {
  const float* x;
  const float* y;
  const float* z;
  std::size_t count;
};

/// encodings: n × (levels · kFeatures).
void encode(std::span<const GridLevel> levels, const float* table, const Points& points, float* encodings);

/// Adds the gradient of one level's features to the level's entries (entry 0 = the level's first). Point i's gradient
/// is the kFeatures floats at feature_gradients + i · stride. Points that follow each other in one cell are summed
/// before memory is touched.
void scatter_level(const GridLevel& level, const Points& points, const float* feature_gradients, std::size_t stride,
                   float* table_gradient);

} // namespace kinora::fields::kernels
