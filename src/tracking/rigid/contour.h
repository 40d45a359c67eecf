// The rim of a rigid layer in a picture: where a shape slides along itself, its outline does not.
// Source: Stoiber et al., "Iterative Corresponding Geometry", CVPR 2022 (an outline along its normals, beside depth).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tracking/rigid/residuals.h"

namespace kinora::tracking {

/// Where the camera sees past the layer on one side, in one view.
struct ContourPoint {
  Eigen::Vector3d position; ///< in the camera, at the layer's depth
  Eigen::Vector2d normal;   ///< unit, in the picture, out of the layer
};

/// The label's border without what something nearer, or the picture's border, may have cut. Thread-safe.
std::vector<ContourPoint> contour_of(const LayerView& view);

/// Distance between two rims; sigma is 1 pixel.
struct ContourResidual : Residual {
  /// The jacobian as the other rim tells it: `jacobian` takes its normal from the later rim and its depth from the
  /// earlier one, this the converse. Their errors are independent: those of either square themselves to information
  /// that is none, those of the product average to nothing.
  Twist counterpart;
};

/// Finds the nearest point of a view's rim. Immutable.
class ContourMap {
public:
  explicit ContourMap(const LayerView& view);

  bool empty() const { return offsets_.empty(); }
  /// How far a point of an earlier rim lies outside this one, in pixels along this one's normal. Nothing if it leaves
  /// the crop, or no rim of its direction (45°) lies within `reach` pixels.
  std::optional<ContourResidual> residual(const ContourPoint& moved, const LayerView& view, const Pivot& pivot,
                                          double reach) const;

private:
  Image<std::int16_t> offsets_; ///< to the nearest pixel of the rim
  Image<float> points_;         ///< there: normal (2 channels) and depth
};

} // namespace kinora::tracking
