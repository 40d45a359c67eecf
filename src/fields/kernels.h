// The loops that training and drawing spend their time in, vectorised with Highway and chosen at run time for the
// processor. Each does what reference.h says, for many points; tests/fields keeps the two equal.
//
// Rows are contiguous: n × width floats. `n` need not be a multiple of anything. Every function is thread-safe as long
// as outputs do not overlap, and gives the same bits for the same input on the same instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fields/field.h"

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

/// out (n × outputs) = in (n × inputs) · weights (inputs × outputs), then max(0, ·) if `relu`. outputs: a multiple
/// of 16.
void dense(const float* in, std::size_t n, int inputs, const float* weights, int outputs, bool relu, float* out);

/// gradient (inputs × outputs) += inᵀ (n × inputs) · out_gradient (n × outputs). inputs: a multiple of 8; outputs:
/// of 16.
void accumulate_weight_gradient(const float* in, const float* out_gradient, std::size_t n, int inputs, int outputs,
                                float* gradient);

/// gradient[i] = 0 where activated[i] is not positive.
void relu_backward(const float* activated, std::size_t count, float* gradient);

/// Adds the gradient of one level's features to the level's entries (entry 0 = the level's first). Point i's gradient
/// is the kFeatures floats at feature_gradients + i · stride. Points that follow each other in one cell are summed
/// before memory is touched.
void scatter_level(const GridLevel& level, const Points& points, const float* feature_gradients, std::size_t stride,
                   float* table_gradient);

/// For n points whose raw densities are every kGeometry-th float of `geometry`: density = exp(min(raw,
/// kMaxRawDensity)) and passing = exp(−density · length), the share of light that a piece of ray lets through.
void densities(const float* geometry, const float* lengths, std::size_t n, float* density, float* passing);

/// Writes the numbers of the rows (n × kGeometry) in which any element is larger than `limit`, or not a number, in
/// ascending order to `numbers` (room for n), and returns how many.
std::size_t rows_above(const float* rows, std::size_t n, float limit, std::uint32_t* numbers);

/// Adam (Kingma & Ba 2015) without weight decay.
struct AdamStep {
  float learning_rate; ///< with both bias corrections already inside
  float beta1 = 0.9F;
  float beta2 = 0.99F;
  float epsilon = 1e-15F;
};

/// Updates `count` parameters (a multiple of kFeatures) and clears their gradients. One without gradient keeps its
/// value and moments.
void adam(const AdamStep& step, std::size_t count, float* parameters, float* gradients, float* first_moments,
          float* second_moments);

/// Name of the instruction set in use, for reports: "AVX3", "AVX2", …
const char* instruction_set();

} // namespace kinora::fields::kernels
