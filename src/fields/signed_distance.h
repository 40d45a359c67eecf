// The second geometry: the density MLP's first output is a distance from the surface, and density follows from it.
// What comes after, from compositing to drawing, sees logarithms of density and does not know.
// Source: Yariv et al., "Volume Rendering of Neural Implicit Surfaces" (VolSDF), NeurIPS 2021, eq. 2: density is
// Ψ(−s/β)/β with the Laplace distribution's Ψ; here the sharpness is ln 1/β. That the distance is known along rays near
// a measured depth: Azinović et al., "Neural RGB-D Surface Reconstruction", CVPR 2022.
#pragma once

#include <cstddef>
#include <vector>

#include "fields/ray_batch.h"

namespace kinora::fields {

/// For n points whose distances are every kGeometry-th float of `geometry`: moves them to `distances`, and leaves the
/// logarithms of density in their places. Thread-safe.
void to_log_densities(float sharpness, std::size_t n, float* geometry, float* distances);

struct DistanceSums {
  double loss = 0; ///< LossWeights::distance
  double sharpness_gradient = 0;
};

/// Turns ∂loss/∂(logarithm of density) · scale, every kGeometry-th float of `geometry_gradient`, into ∂loss/∂distance ·
/// scale, and adds the loss of the distances themselves. Thread-safe.
DistanceSums distance_backward(const RayBatch& rays, const std::vector<float>& distances, float sharpness,
                               const LossWeights& weights, float scale, float* geometry_gradient);

} // namespace kinora::fields
