// From the density net's output to what volume rendering takes.
// Vectorised with Highway and chosen at run time for the processor; reference.h says what it does, tests/fields keeps
// the two equal. Thread-safe as long as outputs do not overlap; the same bits for the same input on the same
// instruction set.
#pragma once

#include <cstddef>

namespace kinora::fields {

/// Largest raw density before the exponential: e¹¹ per unit of length is opaque to any sample.
inline constexpr float kMaxRawDensity = 11.0F;
/// Added to the opacity when composited features are normalised by it.
inline constexpr float kOpacityEpsilon = 1e-3F;

namespace kernels {

/// For n points whose raw densities are every kGeometry-th float of `geometry`: density = exp(min(raw,
/// kMaxRawDensity)) and passing = exp(−density · length), the share of light that a piece of ray lets through.
void densities(const float* geometry, const float* lengths, std::size_t n, float* density, float* transmittance);

} // namespace kernels

} // namespace kinora::fields
