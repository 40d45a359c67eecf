// Which nodes move points, and where they carry them: sixteen points at a time in single precision, vectorised with
// Highway and chosen at run time for the processor. tests/motion/skinning/skinned_lanes_test.cpp keeps both equal to
// DeformationGraph::influence and blend_motion, which do the same for one point in double precision.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "motion/skinning/deformation_graph.h"
#include "motion/skinning/node_rows.h"

namespace kinora::motion {

/// Points, or vectors, side by side.
struct PointLanes {
  static constexpr std::size_t kPoints = 16;
  alignas(64) std::array<std::array<float, kPoints>, 3> along; ///< x, y, z; metres

  void set(std::size_t point, const Eigen::Vector3f& value) {
    for (std::size_t axis = 0; axis < 3; ++axis) along[axis][point] = value[static_cast<Eigen::Index>(axis)];
  }
  Eigen::Vector3f at(std::size_t point) const { return {along[0][point], along[1][point], along[2][point]}; }
};

/// What moves each: as Influence, the heaviest node first; a weight of 0 where there is no further node.
struct InfluenceLanes {
  alignas(64) std::array<std::array<std::int32_t, PointLanes::kPoints>, Influence::kMax> nodes;
  alignas(64) std::array<std::array<float, PointLanes::kPoints>, Influence::kMax> weights;

  void set(std::size_t point, const Influence& influence);
  Influence at(std::size_t point) const;
};

/// The nodes that are in question for some points, 255 at most (node_candidates.h).
struct CandidateNodes {
  std::span<const std::int32_t> nodes;
  const PositionRow* positions; ///< of each node of the graph; relative to what the points are relative to
  float influence_radius;       ///< metres
  float weight_radius;          ///< metres
};

/// As DeformationGraph::influence.
void skinning_weights(const CandidateNodes& nodes, const PointLanes& points, InfluenceLanes& influences);

/// As blend_motion and BlendedMotion::apply: NaN where nothing moves a point.
void skin_points(std::span<const TransformRow> transforms, const InfluenceLanes& influences, const PointLanes& points,
                 PointLanes& positions);
/// The same, and as BlendedMotion::rotate of a vector at each point.
void skin_points(std::span<const TransformRow> transforms, const InfluenceLanes& influences, const PointLanes& points,
                 PointLanes& positions, const PointLanes& vectors, PointLanes& rotated);

} // namespace kinora::motion
