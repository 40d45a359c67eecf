// Matrices of the field's small MLPs on rows of points, forward and backward.
// Rows are contiguous: n × width floats. `n` need not be a multiple of anything.
// Vectorised with Highway and chosen at run time for the processor; reference.h says what it does, tests/fields keeps
// the two equal. Thread-safe as long as outputs do not overlap; the same bits for the same input on the same
// instruction set.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kinora::fields::kernels {

/// out (n × outputs) = in (n × inputs) · weights (inputs × outputs), then max(0, ·) if `relu`. outputs: a multiple
/// of 16.
void dense(const float* in, std::size_t n, int inputs, const float* weights, int outputs, bool relu, float* out);

/// gradient (inputs × outputs) += inᵀ (n × inputs) · out_gradient (n × outputs). inputs: a multiple of 8; outputs:
/// of 16.
void accumulate_weight_gradient(const float* in, const float* out_gradient, std::size_t n, int inputs, int outputs,
                                float* gradient);

/// gradient[i] = 0 where activated[i] is not positive.
void relu_backward(const float* activated, std::size_t count, float* gradient);

/// Writes the numbers of the rows (n × kGeometry) in which any element is larger than `limit`, or not a number, in
/// ascending order to `numbers` (room for n), and returns how many.
std::size_t rows_above(const float* rows, std::size_t n, float limit, std::uint32_t* numbers);

} // namespace kinora::fields::kernels
