#include "fields/field_batch.h"

namespace kinora::fields {
namespace {

void grow(std::vector<float>& buffer, std::size_t rows, int width) {
  const std::size_t needed = rows * static_cast<std::size_t>(width);
  if (buffer.size() < needed) buffer.resize(needed);
}

} // namespace

void evaluate_points(const Field& field, std::span<const GridLevel> levels, const kernels::Points& points,
                     PointBatch& batch) {
  const int width = field.config.encoding_width();
  grow(batch.encoding, points.count, width);
  grow(batch.hidden, points.count, FieldConfig::kHidden);
  grow(batch.geometry, points.count, FieldConfig::kGeometry);
  const float* net = field.density_net.data();
  kernels::encode(levels, field.table.data(), points, batch.encoding.data());
  kernels::dense(batch.encoding.data(), points.count, width, net, FieldConfig::kHidden, true, batch.hidden.data());
  kernels::dense(batch.hidden.data(), points.count, FieldConfig::kHidden, net + width * FieldConfig::kHidden,
                 FieldConfig::kGeometry, false, batch.geometry.data());
}

void evaluate_colors(const Field& field, std::size_t n, ColorBatch& batch) {
  constexpr int kHidden = FieldConfig::kColorHidden;
  grow(batch.first, n, kHidden);
  grow(batch.second, n, kHidden);
  grow(batch.output, n, FieldConfig::kColorOutputs);
  const float* net = field.color_net.data();
  kernels::dense(batch.input.data(), n, FieldConfig::kGeometry, net + kColorFirst, kHidden, true, batch.first.data());
  kernels::dense(batch.first.data(), n, kHidden, net + kColorSecond, kHidden, true, batch.second.data());
  kernels::dense(batch.second.data(), n, kHidden, net + kColorThird, FieldConfig::kColorOutputs, false,
                 batch.output.data());
}

void append_transposed(const float* weights, int rows, int columns, std::vector<float>& out) {
  for (int c = 0; c < columns; ++c) {
    for (int r = 0; r < rows; ++r) out.push_back(weights[r * columns + c]);
  }
}

} // namespace kinora::fields
