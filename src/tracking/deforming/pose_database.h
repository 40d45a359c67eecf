// Poses of a bending layer that were tracked well: where to begin when it was lost and is seen again.
#pragma once

#include <span>

#include <Eigen/Geometry>

#include "core/diverse_set.h"
#include "core/se3.h"

namespace kinora::tracking {

/// Frames in which the layer was bent or turned, seen from the camera, otherwise than in all others that are kept: by
/// 14° in the mean square over its nodes. At most 48. Not thread-safe.
class PoseDatabase {
public:
  struct Entry {
    std::size_t frame;   ///< where the nodes were then is the tracker's to know, also of nodes that were found later
    SE3 world_to_camera; ///< then
    std::vector<Eigen::Quaterniond> rotations; ///< of some nodes, canonical to camera
  };

  /// A frame that was tracked; `nodes` canonical to world, of which there may be more than before.
  void add(std::size_t frame, const SE3& world_to_camera, std::span<const SE3> nodes);

  const std::vector<Entry>& entries() const { return entries_.entries(); }

private:
  std::size_t stride_ = 0; ///< from one node whose turn is compared to the next
  DiverseSet<Entry> entries_{0.25, 48};
};

} // namespace kinora::tracking
