#include "fields/field_batch.h"

#include "fields/signed_distance.h"

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
  if (field.config.geometry == Geometry::kSignedDistance) grow(batch.distance, points.count, 1);
  const float* net = field.density_net.data();
  for (std::size_t begin = 0; begin < points.count; begin += kPointBlock) {
    const kernels::Points block{points.x + begin, points.y + begin, points.z + begin,
                                std::min(kPointBlock, points.count - begin)};
    float* encoding = batch.encoding.data() + begin * static_cast<std::size_t>(width);
    float* hidden = batch.hidden.data() + begin * FieldConfig::kHidden;
    kernels::encode(levels, field.table.data(), block, encoding);
    kernels::dense(encoding, block.count, width, net, FieldConfig::kHidden, true, hidden);
    kernels::dense(hidden, block.count, FieldConfig::kHidden, net + width * FieldConfig::kHidden,
                   FieldConfig::kGeometry, false, batch.geometry.data() + begin * FieldConfig::kGeometry);
    if (field.config.geometry == Geometry::kSignedDistance) {
      to_log_densities(field.sharpness, block.count, batch.geometry.data() + begin * FieldConfig::kGeometry,
                       batch.distance.data() + begin);
    }
  }
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
