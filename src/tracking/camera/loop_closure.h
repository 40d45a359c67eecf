// Finds where a camera comes back to what it has seen before, though it has drifted farther than alignment reaches.
// A wrong loop spoils all of a map and an open one little: so a place must look alike, both views must lie on each
// other, drift must be able to explain it, several key frames must say the same, and the whole map must follow.
// Source: Latif, Cadena, Neira, "Robust Loop Closing Over Time for Pose Graph SLAM", IJRR 2013 (loops are believed in
// agreement with each other and with the graph).
#pragma once

#include <span>
#include <vector>

#include "tracking/camera/camera_keyframe.h"
#include "tracking/camera/pose_graph.h"

namespace kinora::tracking {

/// Of the key frames `among` all the most like, by their features, the likeliest first; at most `count`.
std::vector<std::size_t> most_similar(const SurfaceFeatures& features, std::span<const CameraKeyframe> keyframes,
                                      std::span<const std::size_t> among, std::size_t count);

struct LoopClosureConfig {
  // Changes of view (view_change).
  double reach = 0.2;            ///< what alignment bridges by itself: key frames so near have been compared
  double drift = 0.05;           ///< that a camera may drift anyhow,
  double drift_rate = 0.1;       ///< and as a share of its way: twice what the worst sensors make of it
  double agreement = 0.06;       ///< that loops seen one after the other may differ by: what drift adds meanwhile
  double residual = 0.03;        ///< that an edge of full weight may still differ by from the settled map
  std::size_t compared = 3;      ///< key frames that look most alike
  std::size_t window = 8;        ///< newest key frames whose loops are looked at together
  std::size_t min_witnesses = 3; ///< different ones of these that must say the same
};

/// Not thread-safe. Deterministic.
class LoopClosure {
public:
  explicit LoopClosure(const LoopClosureConfig& config = {}) : config_(config) {}

  /// Compares the newest key frame with those that it may have drifted away from. Returns edges to be added, from older
  /// key frames to newer ones: none until several agree. `view`: of the newest. `map`: camera to map of each key frame,
  /// tied by `edges`.
  std::vector<PoseEdge> find_loops(std::span<const CameraKeyframe> keyframes, const LayerView& view,
                                   std::span<const SE3> map, std::span<const PoseEdge> edges);

private:
  LoopClosureConfig config_;
  std::vector<PoseEdge> candidates_; ///< by single key frames, not believed yet
};

} // namespace kinora::tracking
