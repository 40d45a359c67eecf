#include "fields/network/field_batch.h"

#include "fields/network/hash_grid.h"
#include "fields/network/mlp.h"
#include "fields/network/volume_density.h"

namespace kinora::fields {
namespace {

void grow(std::vector<float>& buffer, std::size_t rows, int width) {
  const std::size_t needed = rows * static_cast<std::size_t>(width);
  if (buffer.size() < needed) buffer.resize(needed);
}

int width_of(std::span<const GridLevel> levels) { return static_cast<int>(levels.size()) * FieldConfig::kFeatures; }

void evaluate_colors_from(int inputs, const float* first, const Field& field, std::size_t n, ColorBatch& batch) {
  constexpr int kHidden = FieldConfig::kColorHidden;
  grow(batch.first, n, kHidden);
  grow(batch.second, n, kHidden);
  grow(batch.output, n, FieldConfig::kColorOutputs);
  const float* net = field.color_net.data();
  kernels::dense(batch.input.data(), n, inputs, first, kHidden, true, batch.first.data());
  kernels::dense(batch.first.data(), n, kHidden, net + kColorSecond, kHidden, true, batch.second.data());
  kernels::dense(batch.second.data(), n, kHidden, net + kColorThird, FieldConfig::kColorOutputs, false,
                 batch.output.data());
}

} // namespace

void evaluate_points(const Field& field, std::span<const GridLevel> levels, const kernels::Points& points,
                     PointBatch& batch) {
  const int width = width_of(levels);
  grow(batch.encoding, points.count, width);
  grow(batch.hidden, points.count, FieldConfig::kHidden);
  grow(batch.geometry, points.count, FieldConfig::kGeometry);
  if (field.config.geometry == Geometry::kSignedDistance) grow(batch.distance, points.count, 1);
  const float* net = field.density_net.data();
  for (std::size_t begin = 0; begin < points.count; begin += kPointBlock) {
    const kernels::Points block{points.x + begin, points.y + begin, points.z + begin,
                                std::min(kPointBlock, points.count - begin)};
    float* encoding = batch.encoding.data() + begin * static_cast<std::size_t>(width);
    float* hidden = batch.hidden.data() + begin * FieldConfig::kHidden;
    kernels::encode(levels, field.table.data(), block, encoding);
    kernels::dense(encoding, block.count, width, net, FieldConfig::kHidden, true, hidden);
    kernels::dense(hidden, block.count, FieldConfig::kHidden,
                   net + field.config.encoding_width() * FieldConfig::kHidden, FieldConfig::kGeometry, false,
                   batch.geometry.data() + begin * FieldConfig::kGeometry);
    if (field.config.geometry == Geometry::kSignedDistance) {
      to_log_densities(field.sharpness, block.count, batch.geometry.data() + begin * FieldConfig::kGeometry,
                       batch.distance.data() + begin);
    }
  }
}

void evaluate_colors(const Field& field, std::size_t n, ColorBatch& batch) {
  evaluate_colors_from(FieldConfig::kGeometry, field.color_net.data() + kColorFirst, field, n, batch);
}

std::vector<float> surface_matrix(const Field& field) {
  constexpr int kHidden = FieldConfig::kHidden;
  constexpr int kG = FieldConfig::kGeometry;
  constexpr int kC = FieldConfig::kColorHidden;
  const float* features = field.density_net.data() + field.config.encoding_width() * kHidden;
  const float* colors = field.color_net.data() + kColorFirst;
  std::vector<float> matrix;
  for (int h = 0; h < kHidden; ++h) {
    for (int c = 0; c < kC; ++c) {
      float sum = 0;
      for (int g = 1 + kSurfaceVectors; g < kG; ++g) sum += features[h * kG + g] * colors[(g - 1) * kC + c];
      matrix.push_back(sum);
    }
  }
  matrix.insert(matrix.end(), colors + (kG - 1) * kC, colors + kG * kC);
  matrix.insert(matrix.end(), colors, colors + kSurfaceVectors * kC);
  return matrix;
}

std::vector<float> vector_matrix(const Field& field) {
  constexpr int kG = FieldConfig::kGeometry;
  const float* features = field.density_net.data() + field.config.encoding_width() * FieldConfig::kHidden;
  std::vector<float> matrix;
  for (int h = 0; h < FieldConfig::kHidden; ++h) {
    matrix.insert(matrix.end(), features + h * kG + 1, features + h * kG + 1 + kSurfaceVectors);
  }
  return matrix;
}

void evaluate_hidden(const Field& field, std::span<const GridLevel> levels, const kernels::Points& points,
                     PointBatch& batch) {
  const int width = width_of(levels);
  grow(batch.encoding, std::min(points.count, kPointBlock), width);
  grow(batch.hidden, points.count, FieldConfig::kHidden);
  for (std::size_t begin = 0; begin < points.count; begin += kPointBlock) {
    const kernels::Points block{points.x + begin, points.y + begin, points.z + begin,
                                std::min(kPointBlock, points.count - begin)};
    kernels::encode(levels, field.table.data(), block, batch.encoding.data());
    kernels::dense(batch.encoding.data(), block.count, width, field.density_net.data(), FieldConfig::kHidden, true,
                   batch.hidden.data() + begin * FieldConfig::kHidden);
  }
}

void evaluate_surface_colors(const Field& field, const std::vector<float>& surface_matrix, std::size_t n,
                             ColorBatch& batch) {
  evaluate_colors_from(kSurfaceInputs, surface_matrix.data(), field, n, batch);
}

void append_transposed(const float* weights, int rows, int columns, std::vector<float>& out) {
  for (int c = 0; c < columns; ++c) {
    for (int r = 0; r < rows; ++r) out.push_back(weights[r * columns + c]);
  }
}

} // namespace kinora::fields
