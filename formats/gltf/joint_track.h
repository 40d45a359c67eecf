// Where a joint is over time, as glTF wants it.
#pragma once

#include <vector>

#include "kinora/plugin.h"

namespace kinora::formats {

class JointTrack {
public:
  /// Quaternions are brought to the hemisphere of the one before, so that players interpolate the short way.
  void add(const KinoraJoint& joint);

  bool rotates() const { return rotates_; }                                ///< the rotation is not always the same
  bool moves() const { return moves_; }                                    ///< the translation is not always the same
  const std::vector<float>& rotations() const { return rotations_; }       ///< x y z w of each time
  const std::vector<float>& translations() const { return translations_; } ///< x y z of each time

private:
  bool rotates_ = false;
  bool moves_ = false;
  std::vector<float> rotations_;
  std::vector<float> translations_;
};

} // namespace kinora::formats
