// The embedded deformation graph of a layer that bends: nodes in canonical space, and which of them move a point.
// Source: Sumner, Schmid, Pauly, "Embedded Deformation for Shape Manipulation", SIGGRAPH 2007; weights as in
// Jiang et al., "Instant-NVR", CVPR 2023, sec. 4.1: exp(−d²/r²) over the nearest nodes, less the weight that the first
// node left out would have, so that the warp is continuous.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace kinora::motion {

/// The nearest points to a query among a fixed set; a uniform grid. Immutable, thread-safe.
class NearestPoints {
public:
  NearestPoints() = default;
  /// Finds points within `reach` metres (> 0) of a query. Keeps a copy of the points.
  NearestPoints(std::span<const Eigen::Vector3d> points, double reach);

  struct Neighbour {
    int index;
    double squared_distance;
  };
  /// Fills `found` with the nearest points within reach, nearest first (equal distances by index); returns how many.
  std::size_t find(const Eigen::Vector3d& query, std::span<Neighbour> found) const;
  /// The same when only some points are in question.
  std::size_t find(const Eigen::Vector3d& query, std::span<const std::int32_t> among, std::span<Neighbour> found) const;
  const std::vector<Eigen::Vector3d>& points() const { return points_; }

private:
  struct Sorted {
    Eigen::Vector3d point;
    int index;
  };
  std::size_t row_of(int y, int z) const; ///< number of the first cell of a row along x

  double reach_ = 1;
  std::vector<Eigen::Vector3d> points_;
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero(); ///< the grid's corner
  double cells_per_metre_ = 1;
  std::array<int, 3> cells_{};
  std::vector<std::uint32_t> begin_; ///< per cell, into sorted_; one more at the end
  std::vector<Sorted> sorted_;       ///< points by cell
};

/// Which nodes move a canonical point, heaviest first; weights add up to 1. `count` 0: no node is near enough.
struct Influence {
  static constexpr int kMax = 4;
  int count = 0;
  std::array<int, kMax> nodes{};
  std::array<double, kMax> weights{};
};

/// Immutable, thread-safe.
class DeformationGraph {
public:
  /// `nodes`: canonical positions, metres. `weight_radius` r and `influence_radius` (farthest node that may move a
  /// point) in metres, both > 0. Throws Error(kFailure) without nodes or with radii that are not positive.
  DeformationGraph(std::vector<Eigen::Vector3d> nodes, double weight_radius, double influence_radius);

  const std::vector<Eigen::Vector3d>& nodes() const { return nearest_.points(); }
  double weight_radius() const { return weight_radius_; }
  double influence_radius() const { return influence_radius_; }

  Influence influence(const Eigen::Vector3d& canonical) const;
  /// The same when only some nodes are in question (node_candidates.h).
  Influence influence(const Eigen::Vector3d& canonical, std::span<const std::int32_t> candidates) const;

private:
  /// Of the nearest nodes, one more than have a say.
  Influence weighted(std::span<const NearestPoints::Neighbour> nearest) const;

  double weight_radius_;
  double influence_radius_;
  NearestPoints nearest_;
};

} // namespace kinora::motion
