// The searches that what training does is measured against: every node is looked at for every point, sixteen points at
// a time with the same vectors.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "motion/skinning/node_rows.h"
#include "motion/warp.h"

namespace kinora::bench {

class BruteForce {
public:
  using Point = std::array<float, 3>;
  static constexpr int kMaxNodes = 1023;

  BruteForce(const motion::DeformationGraph& graph, const motion::Warp& warp);

  /// Coordinates of points are relative to these.
  const Eigen::Vector3d& canonical_origin() const { return canonical_origin_; }
  const Eigen::Vector3d& world_origin() const { return world_origin_; }

  /// The four nodes that are nearest in the live frame, their blend inverted: Instant-NVR without its table, eq. 4.
  void by_live_nodes(std::span<const Point> world, Point* canonical) const;
  /// From there Newton's fixed point, to 0.1 mm, with the nodes that are nearest in canonical space, each time of all;
  /// not a number where it does not settle.
  void exactly(std::span<const Point> world, Point* canonical) const;

  /// What the loops read: transforms from canonical to world coordinates.
  struct Nodes {
    std::vector<motion::PositionRow> live, canonical;
    std::vector<motion::TransformRow> transforms;
    float inverse_squared_weight_radius = 0;
    float squared_influence_radius = 0;
  };

private:
  Eigen::Vector3d canonical_origin_, world_origin_;
  Nodes nodes_;
};

} // namespace kinora::bench
