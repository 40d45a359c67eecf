// The outside of what density bricks hold as a mesh of cubes: carried along by the layer's motion and rasterised, it
// tells where each pixel's ray enters the layer, and where in canonical space.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fields/density_bricks.h"
#include "tracking/warp.h"

namespace kinora::fields {

/// Corners of a face, counterclockwise seen from outside; indices into the hull's corners.
using HullFace = std::array<std::uint32_t, 4>;

/// A brick is divided into 2³ cells; those that hold anything make up the hull. Thread-safe, but for follow().
class BrickHull {
public:
  static constexpr int kCellSide = DensityBricks::kSide / 2; ///< lattice steps

  BrickHull() = default;
  BrickHull(const DensityBricks& bricks, const FieldBox& box);

  struct Cell {
    std::array<std::uint32_t, 8> corners;   ///< x fastest
    std::array<std::int32_t, 6> neighbours; ///< −x, +x, −y, +y, −z, +z; −1: none
  };
  const std::vector<Eigen::Vector3d>& corners() const { return corners_; } ///< canonical, metres
  const std::vector<Eigen::Vector3f>& places() const { return places_; }   ///< of the corners, lattice steps
  const std::vector<Cell>& cells() const { return cells_; }
  /// Number of a cell by its coordinates, in cells; −1: none.
  std::int32_t cell_at(const DensityBricks& bricks, int x, int y, int z) const;
  /// Faces between a cell and none.
  const std::vector<HullFace>& faces() const { return faces_; }
  Eigen::Vector3d middle(std::size_t cell) const {
    return 0.5 * (corners_[cells_[cell].corners[0]] + corners_[cells_[cell].corners[7]]);
  }
  /// Faces between a cell that is kept (≠ 0) and one that is not, or none. Uses all threads.
  std::vector<HullFace> faces_of(const std::vector<std::uint8_t>& kept) const;
  /// What moves the corners, and the middles of the cells; empty unless follow() was called.
  const std::vector<tracking::Influence>& influences() const { return influences_; }
  const std::vector<tracking::Influence>& middle_influences() const { return middle_influences_; }
  /// Prepares for being posed by this graph. Uses all threads.
  void follow(const tracking::DeformationGraph& graph);
  double cell_side() const { return cell_side_; } ///< metres

private:
  double cell_side_ = 0;
  std::vector<Eigen::Vector3d> corners_;
  std::vector<Eigen::Vector3f> places_;
  std::vector<Cell> cells_;
  std::vector<std::array<std::int32_t, 8>> cells_of_brick_; // −1: none
  std::vector<HullFace> faces_;
  std::vector<tracking::Influence> influences_, middle_influences_;
};

/// The hull of a deforming layer at one instant. Immutable, thread-safe. A cell that the motion would tear, because
/// parts of the surface that have parted meet in it, is carried rigidly, with its middle; faces close the hull around
/// it.
class PosedHull {
public:
  /// `hull` follows the graph of `warp`.
  PosedHull(const BrickHull& hull, const tracking::Warp& warp);

  struct Corner {
    Eigen::Vector3d world;                ///< metres; NaN where the motion is not known
    Eigen::Matrix3f canonical_from_world; ///< rotation
  };
  const std::vector<Corner>& corners() const { return corners_; }
  const std::vector<Eigen::Vector3f>& places() const { return places_; } ///< of the corners, canonical, lattice steps
  /// By the cells' numbers, as BrickHull::Cell::corners.
  const std::vector<std::array<std::uint32_t, 8>>& cells() const { return cells_; }
  const std::vector<HullFace>& faces() const { return faces_; }

private:
  bool is_whole(const std::array<std::uint32_t, 8>& cell, double side) const;
  void carry_corners(const BrickHull& hull, const tracking::Warp& warp);
  void carry_rigidly(const BrickHull& hull, std::span<const std::size_t> cells, const tracking::Warp& warp);

  std::vector<Corner> corners_;
  std::vector<Eigen::Vector3f> places_;
  std::vector<std::array<std::uint32_t, 8>> cells_;
  std::vector<HullFace> faces_;
};

} // namespace kinora::fields
