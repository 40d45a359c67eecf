// Fields that hold a shape exactly, without training: what is drawn of them can be computed.
#pragma once

#include <algorithm>
#include <cmath>

#include "fields/model/field.h"
#include "fields/network/field_batch.h"

namespace kinora::fields::testing {

/// What a painted field holds at a point of canonical space.
struct Paint {
  double distance;                ///< metres to the surface; negative inside
  Eigen::Vector3d color{1, 1, 1}; ///< from 0 to 1
};

constexpr int kPaintedCells = 64;

/// Raw density falls from `inside` to −`inside` within a cell on both sides of the surface; everything within two cells
/// of the inside is occupied. The finer level is stored densely, nets pass its features on unchanged. With `turning`
/// the colour is a vector that turns with the layer, and grey is added to it.
template <class Shape>
Field painted_field(const FieldBox& box, const Shape& shape, float inside = 8, bool turning = false) {
  FieldConfig config;
  config.box = box;
  config.levels = 2;
  config.log2_table_size = 19;
  config.coarsest_resolution = 4;
  config.finest_resolution = kPaintedCells;
  config.occupancy_resolution = 64;
  Field field(config);
  const GridLevel level = grid_levels(config)[1];
  const double cell = config.cell_size();
  const auto at = [&](int x, int y, int z, double offset) {
    return Eigen::Vector3d(box.origin + cell * (Eigen::Vector3d(x, y, z).array() + offset).matrix());
  };
  const int side = kPaintedCells + 1;
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const Paint paint = shape(at(x, y, z, 0));
        float* entry = field.table.data() +
                       (level.offset + static_cast<std::size_t>((z * side + y) * side + x)) * FieldConfig::kFeatures;
        const float raw = -inside * static_cast<float>(std::clamp(paint.distance / cell, -1.0, 1.0));
        entry[0] = std::max(raw, 0.0F);
        entry[1] = std::max(-raw, 0.0F);
        for (int c = 0; c < 3; ++c) entry[2 + c] = static_cast<float>(paint.color[c]);
        if (x < kPaintedCells && y < kPaintedCells && z < kPaintedCells &&
            shape(at(x, y, z, 0.5)).distance < 2 * cell) {
          field.occupancy.set(x, y, z);
        }
      }
    }
  }
  constexpr int kH = FieldConfig::kHidden;
  constexpr int kC = FieldConfig::kColorHidden;
  const auto density = [&field](int row, int column) -> float& {
    const int weight = row * kH + column;
    return field.density_net[static_cast<std::size_t>(weight)];
  };
  constexpr int kFirst = FieldConfig::kFeatures; // features of the finer level
  constexpr int kSecond = 2 * FieldConfig::kFeatures;
  for (int i = 0; i < 5; ++i) density(kFirst + i, i) = 1;
  density(kSecond + 0, 0) = 1;
  density(kSecond + 1, 0) = -1;
  const int first_color = turning ? 0 : 3 * FieldConfig::kVectors; // of the features
  for (int c = 0; c < 3; ++c) density(kSecond + 2 + c, 1 + first_color + c) = 1;
  // Before the sigmoid: 8 · colour − 4.
  float* net = field.color_net.data();
  constexpr int kOne = FieldConfig::kGeometry - 1;
  for (int c = 0; c < 3; ++c) {
    net[kColorFirst + (first_color + c) * kC + c] = 1;
    if (turning) net[kColorFirst + kOne * kC + c] = 0.5F;
    net[kColorSecond + c * kC + c] = 1;
    net[kColorThird + c * FieldConfig::kColorOutputs + c] = 8;
    net[kColorThird + 3 * FieldConfig::kColorOutputs + c] = -4;
  }
  net[kColorFirst + kOne * kC + 3] = 1;
  net[kColorSecond + 3 * kC + 3] = 1;
  return field;
}

/// A ball, coloured by direction.
struct PaintedBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.3;

  Paint operator()(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d from = point - centre;
    const Eigen::Vector3d direction = from / std::max(from.norm(), 1e-9);
    return {from.norm() - radius, 0.5 * (direction.array() + 1).matrix()};
  }
  /// Depth at which a ray origin + depth · direction meets it; 0 if it does not.
  double depth_of(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
    const Eigen::Vector3d from = origin - centre;
    const double b = from.dot(direction) / direction.squaredNorm();
    const double root = b * b - (from.squaredNorm() - radius * radius) / direction.squaredNorm();
    return root < 0 ? 0 : std::max(-b - std::sqrt(root), 0.0);
  }
};

} // namespace kinora::fields::testing
