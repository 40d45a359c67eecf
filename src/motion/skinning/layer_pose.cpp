#include "motion/skinning/layer_pose.h"

#include <algorithm>

#include "core/parallel.h"

namespace kinora::motion {

SkinnedPoint::SkinnedPoint(const Eigen::Vector3f& at, const Eigen::Vector3f& outwards, const Influence& influence)
    : position(at), normal(outwards) {
  nodes.fill(influence.nodes[0]);
  for (std::size_t k = 0; k < static_cast<std::size_t>(influence.count); ++k) {
    nodes[k] = influence.nodes[k];
    weights[k] = static_cast<float>(influence.weights[k]);
  }
}

std::size_t SkinnedPoint::node_count() const {
  return static_cast<std::size_t>(std::find(weights.begin(), weights.end(), 0.0F) - weights.begin());
}

Influence SkinnedPoint::influence() const {
  Influence result;
  result.count = static_cast<int>(node_count());
  for (std::size_t k = 0; k < node_count(); ++k) {
    result.nodes[k] = nodes[k];
    result.weights[k] = static_cast<double>(weights[k]);
  }
  return result;
}

NodeRows rows_of(const NodeStates& nodes) { return {transform_rows(nodes.transforms), position_rows(nodes.positions)}; }

LayerPose pose_layer(std::span<const SkinnedPoint> points, NodeStates nodes) {
  constexpr std::size_t kPointsPerChunk = 1024;
  LayerPose pose;
  pose.rows = rows_of(nodes);
  pose.nodes = std::move(nodes);
  pose.points.resize(points.size());
  parallel_for(points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    const std::size_t count = chunk.end - chunk.begin;
    pose_points(points.subspan(chunk.begin, count), pose.rows.transforms,
                std::span(pose.points).subspan(chunk.begin, count));
  });
  return pose;
}

} // namespace kinora::motion
