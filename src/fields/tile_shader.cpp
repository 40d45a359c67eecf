#include "fields/tile_shader.h"

#include "fields/ray_batch.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kG = FieldConfig::kGeometry;

} // namespace

void TileShader::shade() {
  if (pixels_.empty()) return;
  evaluate_points(layer_->field, layer_->levels, {x_.data(), y_.data(), z_.data(), x_.size()}, points_);
  color_.input.assign(pixels_.size() * kG, 0.0F);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const float* g = points_.geometry.data() + i * kG;
    float* input = color_.input.data() + rows_[i] * kG;
    const float share = weights_[i] / (opacities_[rows_[i]] + kOpacityEpsilon);
    for (std::size_t f = 0; f + 1 < kG; ++f) input[f] += share * g[f + 1];
    input[kG - 1] = 1;
  }
  evaluate_colors(layer_->field, pixels_.size(), color_);
}

} // namespace kinora::fields
