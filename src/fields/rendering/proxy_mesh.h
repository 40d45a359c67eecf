// The outside of what density bricks hold as a mesh of cubes: carried along by the layer's motion and rasterised, it
// tells where each pixel's ray enters the layer, and where in canonical space.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "fields/rendering/density_bricks.h"
#include "fields/rendering/proxy_mesh_kernels.h"
#include "motion/node_births.h"
#include "motion/warp.h"

namespace kinora::fields {

/// Corners of a face, counterclockwise seen from outside; indices into the hull's corners.
using ProxyFace = std::array<std::uint32_t, 4>;

/// A brick is divided into 2³ cells; those that hold anything make up the hull. Thread-safe, but for bind_to().
class ProxyMesh {
public:
  static constexpr int kCellSide = DensityBricks::kSide / 2; ///< lattice steps

  ProxyMesh() = default;
  ProxyMesh(const DensityBricks& bricks, const FieldBox& box);

  struct Cell {
    std::array<std::uint32_t, 8> corners;   ///< x fastest
    std::array<std::int32_t, 6> neighbours; ///< −x, +x, −y, +y, −z, +z; −1: none
  };
  std::size_t corner_count() const { return corner_count_; }
  /// Of the corners, lattice steps; padded (kernels::kPadding).
  const std::vector<Eigen::Vector3f>& positions() const { return positions_; }
  const std::vector<Cell>& cells() const { return cells_; }
  /// Number of a cell by its coordinates, in cells; −1: none.
  std::int32_t cell_at(const DensityBricks& bricks, int x, int y, int z) const;
  /// Per brick the numbers of its cells, x fastest; −1: none.
  const std::vector<std::array<std::int32_t, 8>>& cells_of_brick() const { return cells_of_brick_; }
  /// Faces between a cell and none.
  const std::vector<ProxyFace>& faces() const { return faces_; }
  Eigen::Vector3f middle(std::size_t cell) const { ///< lattice steps
    return 0.5F * (positions_[cells_[cell].corners[0]] + positions_[cells_[cell].corners[7]]);
  }
  /// Faces between a cell that is kept (≠ 0) and one that is not, or none.
  std::vector<ProxyFace> faces_of(const std::vector<std::uint8_t>& kept) const;
  /// What moves the corners, and the middles of the cells; empty unless bind_to() was called.
  const kernels::Influences& influences() const { return influences_; }
  const std::vector<motion::Influence>& middle_influences() const { return middle_influences_; }
  /// Prepares for being posed by this graph. Uses all threads.
  void bind_to(const motion::DeformationGraph& graph);
  /// Gives back the memory of what only a layer that deforms needs: cells() is empty then, faces_of() not to be called.
  void forget_cells();
  /// Per brick 0 where most of what moves its cells is not born yet, else 1; empty if no node is unborn. Only after
  /// bind_to().
  std::vector<std::uint8_t> born_bricks(const motion::UnbornNodes& unborn) const;
  const Eigen::Vector3d& origin() const { return origin_; } ///< canonical place of the lattice's zero, metres
  double lattice_step() const { return lattice_step_; }     ///< metres
  Eigen::Vector3d to_canonical(const Eigen::Vector3f& position) const {
    return origin_ + lattice_step_ * position.cast<double>();
  }

private:
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double lattice_step_ = 0;
  std::size_t corner_count_ = 0;
  std::vector<Eigen::Vector3f> positions_;
  std::vector<Cell> cells_;
  std::vector<std::array<std::int32_t, 8>> cells_of_brick_; // −1: none
  std::vector<ProxyFace> faces_;
  std::vector<std::uint32_t> cell_of_face_;
  kernels::Influences influences_;
  std::vector<motion::Influence> middle_influences_;
};

/// The hull of a deforming layer at one instant. Immutable, thread-safe. A cell that the motion would tear, because
/// parts of the surface that have parted meet in it, is carried rigidly, with its middle; faces close the hull around
/// it. Cells that are not there yet are no part of it.
class PosedProxyMesh {
public:
  /// `proxy_mesh` follows the graph of `warp` and must outlive this. `born`: as ProxyMesh::born_bricks; empty: all are
  /// there.
  PosedProxyMesh(const ProxyMesh& proxy_mesh, const motion::Warp& warp, const std::vector<std::uint8_t>& born = {});

  std::size_t corner_count() const { return positions_.size() - kernels::kPadding; }
  /// Of the corners, in the world relative to origin(): not a number where the motion is not known.
  const kernels::SkinnedPoints& corners() const { return corners_; }
  const Eigen::Vector3d& origin() const { return origin_; } ///< metres
  const std::vector<Eigen::Vector3f>& positions() const {
    return positions_;
  } ///< of the corners, as ProxyMesh::positions
  /// A corner of a cell, as ProxyMesh::Cell::corners.
  std::uint32_t corner(std::size_t cell, std::size_t number) const {
    const std::int32_t split = split_corners_[cell];
    return split < 0 ? proxy_mesh_->cells()[cell].corners[number] : static_cast<std::uint32_t>(split) + number;
  }
  /// Per cell the first of eight corners of its own, in that order; −1: it has those of the hull.
  const std::vector<std::int32_t>& split_corners() const { return split_corners_; }
  const std::vector<ProxyFace>& faces() const { return faces_; }

private:
  bool is_unbroken(const std::array<std::uint32_t, 8>& cell) const;
  void skin_rigidly(std::span<const std::uint32_t> cells, std::span<const motion::TransformRow> transforms);

  const ProxyMesh* proxy_mesh_;
  Eigen::Vector3d origin_;
  kernels::SkinnedPoints corners_;
  std::vector<Eigen::Vector3f> positions_;
  std::vector<std::int32_t> split_corners_;
  std::vector<ProxyFace> faces_;
};

} // namespace kinora::fields
