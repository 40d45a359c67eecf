// Whether a view shows that its camera has left its place.
#pragma once

#include <span>

#include "tracking/rigid/residuals.h"

namespace kinora::tracking {

/// The picture, as far as there are points, in cells that each tell, by the residuals of their points, which of two
/// poses explains them better.
struct StationarityVotes {
  int moved = 0;    ///< cells significantly better explained by the other pose
  int still = 0;    ///< cells significantly better explained by the camera's old place
  double shift = 0; ///< how far the other pose moves the points: visible_shift

  /// The other pose moves the points by more than a pixel or the sensor's noise, the cells that tell are too many to
  /// agree so by chance, and few are against it: where a part of the scene moves, the rest stays.
  bool show_motion() const;
};

/// `points` in the space of the still camera. A cell votes if the mean of its points' gains in robust cost differs from
/// zero by three standard errors. Thread-safe.
StationarityVotes compare_with_stationary(std::span<const ModelPoint> points, const LayerView& view,
                                          const SE3& still_to_camera);

} // namespace kinora::tracking
