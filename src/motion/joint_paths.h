// Where the joints of a person's skeleton are at every frame of a clip.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace kinora::motion {

/// Plain data. `positions`: for each frame of the clip one place for each name, in the world, metres.
struct JointPaths {
  std::vector<std::string> names; ///< small letters, digits and underlines
  std::vector<std::vector<Eigen::Vector3d>> positions;
};

} // namespace kinora::motion
