// A field's nets applied to batches of points and of composited rays.
#pragma once

#include <vector>

#include "fields/model/field.h"
#include "fields/network/hash_grid.h"

namespace kinora::fields {

/// Points that go through all of a net's matrices together, so that their rows stay in the nearest cache.
inline constexpr std::size_t kPointBlock = 64;

/// What a backward pass needs of n points; buffers grow and are kept.
struct PointBatch {
  std::vector<float> encoding; ///< n × encoding_width
  std::vector<float> hidden;   ///< n × kHidden
  std::vector<float> geometry; ///< n × kGeometry: raw density, then 15 features
  std::vector<float> distance; ///< n, of a field of signed distances
};

/// Same for colours of n rays.
struct ColorBatch {
  std::vector<float> input;  ///< n × kGeometry: normalised features, then the constant 1; filled by the caller
  std::vector<float> first;  ///< n × kColorHidden
  std::vector<float> second; ///< n × kColorHidden
  std::vector<float> output; ///< n × kColorOutputs: before the sigmoid
};

/// `levels`: the field's, or the first of them if the others are zero (stored_levels()): the same numbers, sooner.
void evaluate_points(const Field& field, std::span<const GridLevel> levels, const kernels::Points& points,
                     PointBatch& batch);
void evaluate_colors(const Field& field, std::size_t n, ColorBatch& batch);

/// Nothing bends what the density net's last matrix makes of its hidden layer before the colour net's first takes it:
/// for drawing, where surfaces are known, the two are one, but for the vectors, which are turned between them. Input of
/// colours is then a composited hidden row, the constant 1, and the turned vectors.
inline constexpr int kSurfaceVectors = 3 * FieldConfig::kVectors;
inline constexpr int kSurfaceInputs = FieldConfig::kHidden + 1 + kSurfaceVectors;
/// That matrix: kSurfaceInputs × kColorHidden.
std::vector<float> surface_matrix(const Field& field);
/// From a hidden row to its vectors: kHidden × kSurfaceVectors.
std::vector<float> vector_matrix(const Field& field);
/// Fills hidden alone.
void evaluate_hidden(const Field& field, std::span<const GridLevel> levels, const kernels::Points& points,
                     PointBatch& batch);
/// As evaluate_colors(), of inputs n × kSurfaceInputs.
void evaluate_surface_colors(const Field& field, const std::vector<float>& surface_matrix, std::size_t n,
                             ColorBatch& batch);

/// Rows and columns exchanged; appended to `out`.
void append_transposed(const float* weights, int rows, int columns, std::vector<float>& out);

inline constexpr int kColorFirst = 0; ///< offsets of the colour MLP's matrices
inline constexpr int kColorSecond = FieldConfig::kGeometry * FieldConfig::kColorHidden;
inline constexpr int kColorThird = kColorSecond + FieldConfig::kColorHidden * FieldConfig::kColorHidden;

} // namespace kinora::fields
