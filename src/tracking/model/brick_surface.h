// The surface of a layer's volume and what moves it, kept brick by brick: only what a frame has changed is taken anew.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tracking/model/brick_influences.h"
#include "tracking/tsdf/tsdf.h"

namespace kinora::tracking {

/// Thread-safe to read; what renews it needs exclusive use. Same bits for any number of threads.
class BrickSurface {
public:
  /// Takes anew the points of bricks that are marked as changed, or have no mark. `unit_weight`: of a point that was
  /// seen once; 0: not known yet.
  void update_points(const TsdfVolume& volume, std::span<const std::uint8_t> changed, float unit_weight);
  /// Takes anew the skin of bricks whose points, or whose influences, are others than in the last call.
  void update_skinning(const BrickInfluences& influences);

  /// As TsdfVolume::surface_points, brick by brick.
  std::span<const SurfacePoint> points() const { return points_; }
  /// For each point, what moves it; as of the last update_skinning.
  std::span<const motion::Influence> skin() const { return skin_; }
  /// Points of some bricks, those for which `wanted(brick)` holds.
  template <class Wanted> std::vector<SurfacePoint> points_of(const Wanted& wanted) const {
    std::vector<SurfacePoint> points;
    for (std::size_t b = 0; b < pieces_.size(); ++b) {
      if (wanted(b)) points.insert(points.end(), pieces_[b].points.begin(), pieces_[b].points.end());
    }
    return points;
  }

  /// Marks of bricks that hold a point at least as heavy as `min_weight` that none of the nodes that move it comes
  /// within `reach` metres of; among those marked as changed, or without a mark. Without skin, all such bricks.
  std::vector<std::uint8_t> unsupported_bricks(std::span<const Eigen::Vector3d> nodes, double reach, float min_weight,
                                               std::span<const std::uint8_t> changed) const;

  /// Marks of bricks that the frame of that number need not teach: each brick whose surface has been seen often is
  /// taught by every `interval`-th frame only, by turns.
  std::vector<std::uint8_t> skipped(std::size_t frame, std::size_t interval) const;

private:
  struct Piece {
    std::vector<SurfacePoint> points;
    std::vector<motion::Influence> skin;
    bool is_known = false;
    bool is_skinned = false;
    std::uint32_t influences = 0; ///< revision that the skin is of
  };
  std::vector<Piece> pieces_; ///< of each brick
  std::vector<SurfacePoint> points_;
  std::vector<motion::Influence> skin_;
};

} // namespace kinora::tracking
