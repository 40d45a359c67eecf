// Volume rendering of the rays of a chunk, forward and backward (reference.h, ray_loss).
#pragma once

#include <vector>

#include "fields/field_batch.h"
#include "fields/ray_batch.h"

namespace kinora::fields {

/// Compositing of a chunk's rays. `geometry` rows are those of PointBatch.
class ChunkCompositor {
public:
  /// Weights, opacities and normalised features; fills `color.input` with a row for each own ray. `lengths`: those of
  /// the samples.
  void forward(const RayBatch& rays, const std::vector<float>& lengths, const float* geometry,
               const LossWeights& weights, ColorBatch& color);

  /// Loss of the chunk from the colours' outputs; `color_gradient` (own rays × kColorOutputs) is ∂loss/∂output · scale.
  double loss(const RayBatch& rays, const LossWeights& weights, float scale, const ColorBatch& color,
              std::vector<float>& color_gradient) const;

  /// ∂loss/∂geometry · scale (samples × kGeometry) from ∂loss/∂(colour input).
  void backward(const RayBatch& rays, const float* geometry, const LossWeights& weights, float scale,
                const ColorBatch& color, const float* input_gradient, float* geometry_gradient) const;

  std::size_t own_ray_count() const { return own_rays_; }
  double own_opacity_sum() const { return own_opacity_; }

private:
  std::size_t own_rays_ = 0;
  double own_opacity_ = 0;
  std::vector<float> weight_;        // per sample
  std::vector<float> transmittance_; // behind each sample
  std::vector<float> density_;       // per sample
  std::vector<float> depth_term_;    // per sample
  std::vector<float> opacity_;       // per ray
};

} // namespace kinora::fields
