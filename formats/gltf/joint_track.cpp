#include "gltf/joint_track.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kinora::formats {

void JointTrack::add(const KinoraJoint& joint) {
  const double* q = joint.rotation;
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  std::array<float, 4> xyzw{};
  float agreement = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    xyzw[i] = static_cast<float>(q[(i + 1) % 4] / norm);
    if (!rotations_.empty()) agreement += xyzw[i] * rotations_[rotations_.size() - 4 + i];
  }
  if (agreement < 0) {
    for (float& v : xyzw) v = -v;
  }
  std::array<float, 3> translation{};
  for (std::size_t i = 0; i < 3; ++i) translation[i] = static_cast<float>(joint.translation[i]);
  if (!rotations_.empty()) {
    rotates_ = rotates_ || !std::equal(xyzw.begin(), xyzw.end(), rotations_.begin());
    moves_ = moves_ || !std::equal(translation.begin(), translation.end(), translations_.begin());
  }
  rotations_.insert(rotations_.end(), xyzw.begin(), xyzw.end());
  translations_.insert(translations_.end(), translation.begin(), translation.end());
}

} // namespace kinora::formats
