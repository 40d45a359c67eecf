#include "fields/rendering/tile_shader.h"

#include "fields/network/ray_batch.h"
#include "fields/network/volume_density.h"
#include "fields/rendering/shading.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kHidden = FieldConfig::kHidden;

} // namespace

void TileShader::shade() {
  if (pixels_.empty()) return;
  evaluate_hidden(layer_->field, layer_->levels,
                  {points_->at[0].data(), points_->at[1].data(), points_->at[2].data(), count_}, batch_);
  color_.input.resize(pixels_.size() * kSurfaceInputs);
  for (std::size_t i = 0; i < count_;) {
    const std::uint32_t row = points_->row[i];
    std::array<float, kHidden> sum{};
    for (; i < count_ && points_->row[i] == row; ++i) {
      const float* hidden = batch_.hidden.data() + i * kHidden;
      for (std::size_t h = 0; h < kHidden; ++h) sum[h] += points_->weight[i] * hidden[h];
    }
    float* input = color_.input.data() + row * kSurfaceInputs;
    const float normaliser = 1 / (opacities_[row] + kOpacityEpsilon);
    for (std::size_t h = 0; h < kHidden; ++h) input[h] = normaliser * sum[h];
    input[kHidden] = 1;
    float* vectors = input + kHidden + 1;
    std::fill_n(vectors, kSurfaceVectors, 0.0F);
    const float* matrix = layer_->vector_matrix.data();
    for (std::size_t h = 0; h < kHidden; ++h) {
      for (int v = 0; v < kSurfaceVectors; ++v) vectors[v] += input[h] * *matrix++;
    }
    rotate_vectors(rotations_[row], vectors);
  }
  evaluate_surface_colors(layer_->field, layer_->surface_matrix, pixels_.size(), color_);
  colors_.resize(4 * pixels_.size());
  kernels::to_colors(color_.output.data(), pixels_.size(), colors_.data());
}

} // namespace kinora::fields
