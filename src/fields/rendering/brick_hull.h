// The outside of what density bricks hold as a mesh of cubes: carried along by the layer's motion and rasterised, it
// tells where each pixel's ray enters the layer, and where in canonical space.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fields/rendering/density_bricks.h"
#include "fields/rendering/hull_kernels.h"
#include "motion/warp.h"

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
  std::size_t corner_count() const { return corner_count_; }
  /// Of the corners, lattice steps; padded (kernels::kPadding).
  const std::vector<Eigen::Vector3f>& places() const { return places_; }
  const std::vector<Cell>& cells() const { return cells_; }
  /// Number of a cell by its coordinates, in cells; −1: none.
  std::int32_t cell_at(const DensityBricks& bricks, int x, int y, int z) const;
  /// Per brick the numbers of its cells, x fastest; −1: none.
  const std::vector<std::array<std::int32_t, 8>>& cells_of_brick() const { return cells_of_brick_; }
  /// Faces between a cell and none.
  const std::vector<HullFace>& faces() const { return faces_; }
  Eigen::Vector3f middle(std::size_t cell) const { ///< lattice steps
    return 0.5F * (places_[cells_[cell].corners[0]] + places_[cells_[cell].corners[7]]);
  }
  /// Faces between a cell that is kept (≠ 0) and one that is not, or none.
  std::vector<HullFace> faces_of(const std::vector<std::uint8_t>& kept) const;
  /// What moves the corners, and the middles of the cells; empty unless follow() was called.
  const kernels::Influences& influences() const { return influences_; }
  const std::vector<motion::Influence>& middle_influences() const { return middle_influences_; }
  /// Prepares for being posed by this graph. Uses all threads.
  void follow(const motion::DeformationGraph& graph);
  const Eigen::Vector3d& origin() const { return origin_; } ///< canonical place of the lattice's zero, metres
  double lattice_step() const { return lattice_step_; }     ///< metres
  Eigen::Vector3d to_canonical(const Eigen::Vector3f& place) const {
    return origin_ + lattice_step_ * place.cast<double>();
  }

private:
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double lattice_step_ = 0;
  std::size_t corner_count_ = 0;
  std::vector<Eigen::Vector3f> places_;
  std::vector<Cell> cells_;
  std::vector<std::array<std::int32_t, 8>> cells_of_brick_; // −1: none
  std::vector<HullFace> faces_;
  std::vector<std::uint32_t> cell_of_face_;
  kernels::Influences influences_;
  std::vector<motion::Influence> middle_influences_;
};

/// The hull of a deforming layer at one instant. Immutable, thread-safe. A cell that the motion would tear, because
/// parts of the surface that have parted meet in it, is carried rigidly, with its middle; faces close the hull around
/// it.
class PosedHull {
public:
  /// `hull` follows the graph of `warp` and must outlive this.
  PosedHull(const BrickHull& hull, const motion::Warp& warp);

  std::size_t corner_count() const { return places_.size() - kernels::kPadding; }
  /// Of the corners, in the world relative to origin(): not a number where the motion is not known.
  const kernels::CarriedPoints& corners() const { return corners_; }
  const Eigen::Vector3d& origin() const { return origin_; }              ///< metres
  const std::vector<Eigen::Vector3f>& places() const { return places_; } ///< of the corners, as BrickHull::places
  /// A corner of a cell, as BrickHull::Cell::corners.
  std::uint32_t corner(std::size_t cell, std::size_t number) const {
    const std::int32_t own = own_corners_[cell];
    return own < 0 ? hull_->cells()[cell].corners[number] : static_cast<std::uint32_t>(own) + number;
  }
  /// Per cell the first of eight corners of its own, in that order; −1: it has those of the hull.
  const std::vector<std::int32_t>& own_corners() const { return own_corners_; }
  const std::vector<HullFace>& faces() const { return faces_; }

private:
  bool is_whole(const std::array<std::uint32_t, 8>& cell) const;
  void carry_rigidly(std::span<const std::uint32_t> cells, std::span<const motion::TransformRow> transforms);

  const BrickHull* hull_;
  Eigen::Vector3d origin_;
  kernels::CarriedPoints corners_;
  std::vector<Eigen::Vector3f> places_;
  std::vector<std::int32_t> own_corners_;
  std::vector<HullFace> faces_;
};

} // namespace kinora::fields
