// What training minimises: each term of a ray's loss, and its gradient. loss_reference.h has the whole for one ray.
// Sources: Jiang et al., "Instant-NVR", CVPR 2023, eq. 4 (colour, depth, free space); Azinović et al., "Neural RGB-D
// Surface Reconstruction", CVPR 2022 (distances near a measured depth).
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/sensor_noise.h"
#include "fields/network/ray_batch.h"

namespace kinora::fields {

/// The loss of a foreground ray is color·‖C − C*‖² + opacity·(1 − A)² + depth·Σᵢ wᵢ min(((zᵢ − z*)/band)²,
/// depth_clamp), of any other free_space·A, with wᵢ the compositing weights and A their sum. A field of signed
/// distances sᵢ adds to an own ray's distance·Σᵢ ((sᵢ − (z* − zᵢ))/band)², over the samples in the band and in metres
/// of depth along the ray. The loss of a step is the mean over its rays, of which `free_space_rays` are a share.
struct LossWeights {
  float color = 1.0F;
  float opacity = 0.1F;
  float depth = 0.03F;
  float free_space = 0.5F;
  float free_space_rays = 0.25F; ///< that are not the layer's own, where there are any
  float depth_clamp = 4.0F;
  float distance = 0.1F;
  SensorNoise noise = {}; ///< of the layer's measured depths; bands widen with it
};

/// min(((z − z*)/band)², depth_clamp) of a sample at depth z.
template <class T> T depth_term(T depth, const RayTarget& target, const LossWeights& weights) {
  const T residual = (depth - T(target.depth)) * T(target.inverse_band);
  return std::min(residual * residual, T(weights.depth_clamp));
}

/// opacity·(1 − A)² of a foreground ray; `transmittance` is 1 − A.
template <class T> T opacity_term(T transmittance, const LossWeights& weights) {
  return T(weights.opacity) * transmittance * transmittance;
}

/// scale · ∂opacity_term/∂A.
template <class T> T opacity_gradient(T scale, T transmittance, const LossWeights& weights) {
  return -scale * T(2) * T(weights.opacity) * transmittance;
}

/// free_space·A of a ray of opacity A that is no foreground ray: what is seen past is empty.
template <class T> T free_space_term(T opacity, const LossWeights& weights) { return T(weights.free_space) * opacity; }

/// scale · ∂free_space_term/∂A.
template <class T> T free_space_gradient(T scale, const LossWeights& weights) { return scale * T(weights.free_space); }

/// Sums over the foreground rays of a chunk.
struct ColorSums {
  double squared_error = 0;       ///< ‖C − C*‖²
  double squared_target = 0;      ///< ‖C*‖²
  std::array<double, 3> target{}; ///< C*

  void add(const ColorSums& other);
};

/// Compares the own rays' colours, from the colour MLP's outputs (own rays × kColorOutputs), with their targets;
/// `gradient` (same size) is ∂loss/∂output · scale.
ColorSums compare_colors(const RayBatch& rays, const float* outputs, const LossWeights& weights, float scale,
                         std::vector<float>& gradient);

/// How far signed distances are from what the depth measured on their rays implies: adds scale · ∂loss/∂distance to
/// every kGeometry-th float of `geometry_gradient`. `distances`: one per sample. Returns the loss. Thread-safe.
double distance_loss(const RayBatch& rays, const std::vector<float>& distances, const LossWeights& weights, float scale,
                     float* geometry_gradient);

} // namespace kinora::fields
