// What points of a layer are compared with in a view, and by how much they miss it: residuals and their derivatives, in
// single precision. Vectorised with Highway and chosen at run time for the processor;
// tests/tracking/solver/data_term_test.cpp keeps them equal to plain loops.
#pragma once

#include <array>
#include <span>

#include "motion/skinning/layer_pose.h"
#include "tracking/solver/jacobian_products.h"
#include "tracking/view/layer_view.h"

namespace kinora::tracking {

/// What a point is compared with, fixed while the solver steps. A scale is the root of a term's weight over its
/// standard deviation; zero: there is no such term.
struct DataTerm {
  static constexpr std::size_t kTextures = 2;
  Eigen::Vector3f plane_normal = Eigen::Vector3f::Zero(); ///< of the measured surface, in the camera
  float plane_offset = 0;                                 ///< plane_normal · x + offset = 0 on it
  std::array<float, kTextures> expected{};                ///< textures at the point
  std::array<float, kTextures> texture_scale{};
  float plane_scale = 0;
  bool on_surface = false;          ///< the plane is of measured surface, no border of a silhouette
  bool violates_free_space = false; ///< the camera sees what lies behind the point
};

/// A residual and its derivative by the point's place, times the root of its weight. All textures are one row, as their
/// derivatives are parallel.
struct ResidualRow {
  Eigen::Vector3f gradient;
  float residual;
};
/// The plane's, then that of the textures; zero where there is no such term.
using ResidualRows = std::array<ResidualRow, PointJacobians::kRows>;

/// What the kernels read of a view: its camera, and one level of its texture.
struct TextureImage {
  float fx, fy, cx, cy;
  const float* values; ///< three channels: TextureLevel
  std::int32_t width, height;
  float scale;
};
TextureImage texture_image(const LayerView& view, int level);

/// Half the sum of squares of all residuals in standard deviations, growing linearly beyond `huber` of them.
/// Spans here and below have the same size, one item for each point. Serial.
double data_energy(std::span<const motion::PosedPoint> points, std::span<const DataTerm> terms,
                   const TextureImage& texture, double huber);

/// Returns that energy, with all rows.
double evaluate_rows(std::span<const motion::PosedPoint> points, std::span<const DataTerm> terms,
                     const TextureImage& texture, double huber, std::span<ResidualRows> rows);

/// Returns that energy, with the rows' derivatives by the twists of the nodes that carry the points.
double evaluate_jacobians(std::span<const motion::SkinnedPoint> skinned, const motion::NodeRows& nodes,
                          std::span<const motion::PosedPoint> points, std::span<const DataTerm> terms,
                          const TextureImage& texture, double huber, std::span<PointJacobians> jacobians);

} // namespace kinora::tracking
