#include "fields/tile_shader.h"

#include "fields/ray_batch.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kHidden = FieldConfig::kHidden;

} // namespace

void TileShader::shade() {
  if (pixels_.empty()) return;
  evaluate_hidden(layer_->field, layer_->levels, {x_.data(), y_.data(), z_.data(), x_.size()}, points_);
  color_.input.assign(pixels_.size() * kSurfaceInputs, 0.0F);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const float* hidden = points_.hidden.data() + i * kHidden;
    float* input = color_.input.data() + rows_[i] * kSurfaceInputs;
    const float share = weights_[i] / (opacities_[rows_[i]] + kOpacityEpsilon);
    for (std::size_t h = 0; h < kHidden; ++h) input[h] += share * hidden[h];
    input[kHidden] = 1;
  }
  evaluate_surface_colors(layer_->field, layer_->surface_matrix, pixels_.size(), color_);
}

} // namespace kinora::fields
