#include "tracking/layer_pose.h"

#include "core/parallel.h"

namespace kinora::tracking {

LayerPose pose_layer(std::span<const SkinnedPoint> points, NodeStates nodes) {
  constexpr std::size_t kPointsPerChunk = 512;
  LayerPose pose;
  pose.nodes = std::move(nodes);
  pose.motions.resize(points.size());
  pose.places.resize(points.size());
  parallel_for(points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    for (std::size_t p = chunk.begin; p < chunk.end; ++p) {
      pose.motions[p] = blend_motion(pose.nodes, points[p].influence);
      pose.places[p] = pose.motions[p].apply(points[p].position);
    }
  });
  return pose;
}

} // namespace kinora::tracking
