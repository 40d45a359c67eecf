// How long a moving camera takes to read the rows of a picture (rolling_shutter.h), by what a field shows that was
// trained with its frames.
#pragma once

#include <optional>
#include <span>

#include "encode/pose_refinement.h"

namespace kinora::encode {

/// By how many seconds reading takes longer than was taken.
struct ReadoutBeyond {
  double color;
  double depth;
  double deviation; ///< standard, of colour, by how stretches of the capture differ

  /// Of colour: to four deviations, and enough to be seen (2 ms).
  bool is_certain() const;
};

/// By least squares over all frames with their poses free. Nothing with too few frames.
std::optional<ReadoutBeyond> readout_beyond(std::span<const std::optional<PoseCorrection>> corrections);

/// Where what is beyond vanishes, by two looks at it: a field that was trained with too short a time has taken in a
/// part of the difference, so one look tells too little.
class ReadoutSearch {
public:
  /// `longest`: seconds; no camera takes longer than from one frame to the next.
  explicit ReadoutSearch(double longest) : longest_(longest) {}

  /// Seconds that reading takes, as far as is known; negative: the last row is first. Depth may be read otherwise than
  /// colour: all at once, as a rule, by a sensor of infrared pictures.
  double color() const { return color_; }
  double depth() const { return depth_; }
  /// Once poses have been refined with it. True if it is another now that another look should confirm.
  bool look(std::span<const std::optional<PoseCorrection>> corrections);

private:
  double longest_;
  double color_ = 0;
  double depth_ = 0;
  double first_beyond_ = 0; ///< of colour; 0: not looked yet, or nothing was found
};

} // namespace kinora::encode
