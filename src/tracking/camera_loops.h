// Finds where a camera comes back to what it has seen before, though it has drifted farther than alignment reaches.
// A wrong loop spoils all of a map and an open one little: so a place must look alike, both views must lie on each
// other, drift must be able to explain it, several key frames must say the same, and the whole map must follow.
// Source: Latif, Cadena, Neira, "Robust Loop Closing Over Time for Pose Graph SLAM", IJRR 2013 (loops are believed in
// agreement with each other and with the graph).
#pragma once

#include <span>
#include <vector>

#include "tracking/camera_keyframe.h"
#include "tracking/pose_graph.h"

namespace kinora::tracking {

/// Of the key frames `among` all the most like, by their features, the likeliest first; at most `count`.
std::vector<std::size_t> most_alike(const SurfaceFeatures& features, std::span<const CameraKeyframe> keyframes,
                                    std::span<const std::size_t> among, std::size_t count);

/// Not thread-safe. Deterministic.
class CameraLoops {
public:
  /// Compares the newest key frame with those that it may have drifted away from. Returns edges to be added, from older
  /// key frames to newer ones: none until several agree. `view`: of the newest. `map`: camera to map of each key frame,
  /// tied by `edges`.
  std::vector<PoseEdge> look_back(std::span<const CameraKeyframe> keyframes, const ObjectView& view,
                                  std::span<const SE3> map, std::span<const PoseEdge> edges);

private:
  std::vector<PoseEdge> seen_; ///< by single key frames, not believed yet
};

} // namespace kinora::tracking
