// The points of a layer where its nodes have them, in single precision: camera and canonical space are both near, so
// that its error is micrometres. Blended by vectorised kernels, chosen at run time for the processor;
// tests/motion/skinning/layer_pose_test.cpp keeps them equal to blended_motion.h.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "motion/skinning/blended_motion.h"
#include "motion/skinning/node_rows.h"

namespace kinora::motion {

/// A point of the model with the nodes that carry it: rows of four numbers, as the kernels read them. Canonical,
/// relative to the layer's origin.
struct SkinnedPoint {
  Eigen::Vector3f position;
  float unused_position = 0;
  Eigen::Vector3f normal;
  float unused_normal = 0;
  std::array<float, Influence::kMax> weights{}; ///< heaviest first; zero: there is no such node
  std::array<std::int32_t, Influence::kMax> nodes{};

  SkinnedPoint(const Eigen::Vector3f& at, const Eigen::Vector3f& outwards, const Influence& influence);
  /// How many nodes carry the point.
  std::size_t node_count() const;
  Influence influence() const;
};
static_assert(sizeof(SkinnedPoint) == 64);

/// A point in the camera; rows of four numbers.
struct PosedPoint {
  Eigen::Vector3f position;
  float unused_position = 0;
  Eigen::Vector3f normal;
  float unused_normal = 0;
};
static_assert(sizeof(PosedPoint) == 32);

/// What kernels read of nodes.
struct NodeRows {
  std::vector<TransformRow> transforms;
  std::vector<PositionRow> positions; ///< in the camera
};

/// Plain data.
struct LayerPose {
  NodeStates nodes;
  NodeRows rows;                  ///< of the nodes
  std::vector<PosedPoint> points; ///< of each point, in the camera
};

NodeRows rows_of(const NodeStates& nodes);

/// `posed`: one for each point; not a number for one that no node carries. Serial.
void pose_points(std::span<const SkinnedPoint> points, std::span<const TransformRow> nodes,
                 std::span<PosedPoint> posed);

/// Uses all threads; same bits for any number of them.
LayerPose pose_layer(std::span<const SkinnedPoint> points, NodeStates nodes);

} // namespace kinora::motion
