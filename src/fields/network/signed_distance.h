// The second geometry: the density MLP's first output is a distance from the surface, and density follows from it.
// What comes after, from compositing to drawing, sees logarithms of density and does not know.
// Source: Yariv et al., "Volume Rendering of Neural Implicit Surfaces" (VolSDF), NeurIPS 2021, eq. 2: density is
// Ψ(−s/β)/β with the Laplace distribution's Ψ; here the sharpness is ln 1/β. That the distance is known along rays near
// a measured depth: Azinović et al., "Neural RGB-D Surface Reconstruction", CVPR 2022.
#pragma once

#include <cstddef>
#include <span>

namespace kinora::fields {

/// For n points whose distances are every kGeometry-th float of `geometry`: moves them to `distances`, and leaves the
/// logarithms of density in their places. Thread-safe.
void to_log_densities(float sharpness, std::size_t n, float* geometry, float* distances);

/// Turns ∂loss/∂(logarithm of density), every kGeometry-th float of `geometry_gradient`, into ∂loss/∂distance, and
/// returns ∂loss/∂sharpness. Thread-safe.
double through_density(std::span<const float> distances, float sharpness, float* geometry_gradient);

} // namespace kinora::fields
