// Volume rendering of the rays of a chunk, forward and backward (loss_reference.h, ray_loss), vectorised with Highway.
#pragma once

#include <vector>

#include "fields/network/field_batch.h"
#include "fields/network/ray_batch.h"
#include "fields/training/loss.h"

namespace kinora::fields {

/// What compositing a chunk's rays forward leaves for the way back.
struct Composition {
  std::vector<float> weight;        ///< per sample
  std::vector<float> transmittance; ///< behind each sample
  std::vector<float> density;       ///< per sample
  std::vector<float> depth_term;    ///< per sample
  std::vector<float> opacity;       ///< per ray
  std::size_t foreground_rays = 0;
  double foreground_opacity = 0; ///< sum over the own rays
  double loss = 0;               ///< of the chunk, so far without that of the colours
};

/// `geometry` rows are those of PointBatch, `lengths` those of the samples. Fills `inputs` with a row of ColorBatch for
/// each own ray.
void composite(const RayBatch& rays, const std::vector<float>& lengths, const float* geometry,
               const LossWeights& weights, Composition& composition, std::vector<float>& inputs);

/// ∂loss/∂geometry · scale (samples × kGeometry) from ∂loss/∂(colour input).
void composite_backward(const RayBatch& rays, const float* geometry, const LossWeights& weights, float scale,
                        const Composition& composition, const std::vector<float>& inputs, const float* input_gradient,
                        float* geometry_gradient);

} // namespace kinora::fields
