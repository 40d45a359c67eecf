// Poses that a body had earlier: where to begin when it was lost and is seen again.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Geometry>

#include "core/diverse_set.h"
#include "tracking/body/skeleton.h"

namespace kinora::tracking {

/// Those that differ from all others that are kept, seen from the camera, by 14° in the mean square over the bones. At
/// most 48. Not thread-safe.
class BodyPoseDatabase {
public:
  /// A pose in the camera, as the body was seen well; `centre` of what was seen of it.
  void add(const BodyPose& pose, const Bones& bones, const Eigen::Vector3d& centre);
  /// All of them in the camera, as if that were seen about `centre`.
  std::vector<BodyPose> about(const Eigen::Vector3d& centre) const;

private:
  struct Entry {
    BodyPose pose; ///< beside the centre
    std::array<Eigen::Quaterniond, kJoints> rotations;
  };
  static double distance(const Entry& a, const Entry& b);

  DiverseSet<Entry> entries_{0.25, 48};
};

} // namespace kinora::tracking
