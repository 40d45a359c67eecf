// From the density net's output to what volume rendering takes. The output is a logarithm of density, or a distance
// from the surface from which density follows; what comes after, from compositing to drawing, sees logarithms of
// density and does not know. Source of the second: Yariv et al., "Volume Rendering of Neural Implicit Surfaces"
// (VolSDF), NeurIPS 2021, eq. 2: density is Ψ(−s/β)/β with the Laplace distribution's Ψ; here the sharpness is ln 1/β.
// That the distance is known along rays near a measured depth: Azinović et al., "Neural RGB-D Surface Reconstruction",
// CVPR 2022. Vectorised with Highway and chosen at run time for the processor; reference.h says what it does,
// tests/fields keeps the two equal. Thread-safe as long as outputs do not overlap; the same bits for the same input on
// the same instruction set.
#pragma once

#include <cstddef>
#include <span>

namespace kinora::fields {

/// Largest raw density before the exponential: e¹¹ per unit of length is opaque to any sample.
inline constexpr float kMaxRawDensity = 11.0F;
/// Added to the opacity when composited features are normalised by it.
inline constexpr float kOpacityEpsilon = 1e-3F;

namespace kernels {

/// For n points whose raw densities are every kGeometry-th float of `geometry`: density = exp(min(raw,
/// kMaxRawDensity)) and transmittance = exp(−density · length), the share of light that a piece of ray lets through.
void densities(const float* geometry, const float* lengths, std::size_t n, float* density, float* transmittance);

} // namespace kernels

/// For n points whose distances are every kGeometry-th float of `geometry`: moves them to `distances`, and leaves the
/// logarithms of density in their places. Thread-safe.
void to_log_densities(float sharpness, std::size_t n, float* geometry, float* distances);

/// Turns ∂loss/∂(logarithm of density), every kGeometry-th float of `geometry_gradient`, into ∂loss/∂distance, and
/// returns ∂loss/∂sharpness. Thread-safe.
double through_density(std::span<const float> distances, float sharpness, float* geometry_gradient);

} // namespace kinora::fields
