// Where the rows of a rolling shutter find what they see in a picture that is of one moment.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/rolling_shutter.h"

namespace kinora {

/// Immutable, so thread-safe.
class RowLookup {
public:
  /// `depth`: metres of a picture as a camera sees it at one moment, 0 where nothing is known (and lies far away);
  /// while rows are read the camera moves by `readout`, in its own space. All must outlive this.
  RowLookup(const DepthImage& depth, const Intrinsics& intrinsics, const Twist& readout);

  struct Place {
    Eigen::Vector2d at;    ///< in the picture, within it; pixels
    double depth = 0;      ///< of what lies there in the row's own camera; 0: nothing does
    bool is_found = false; ///< what lies there is what the row's pixel sees; else that is hidden, or outside
  };
  /// What a pixel of a row sees: of all that it may be, the nearest.
  Place place_of(int u, int v) const;

private:
  double depth_at(const Eigen::Vector2d& at) const;
  Place look(int u, int v, double depth) const;

  const DepthImage& depth_;
  const Intrinsics& intrinsics_;
  std::vector<SE3> to_row_; ///< from the camera at the middle of the rows
  Image<double> nearest_;   ///< the least depth of blocks of pixels, each with those about it
};

} // namespace kinora
