// Finds what points of a layer are compared with in a view. Vectorised with Highway and chosen at run time for the
// processor; tests/tracking/solver/point_association_test.cpp keeps it equal to a plain loop.
#pragma once

#include <array>
#include <span>

#include "tracking/solver/data_term.h"

namespace kinora::tracking {

struct AssociationGates {
  double plane = 0.1;           ///< metres; measured surface farther away than this is another one
  double contour = 0.1;         ///< metres; a rim of the silhouette farther away is another one's
  double silhouette_weight = 1; ///< weight of a point that the camera sees past, for a pixel off the silhouette
};

/// Fills `terms` but for their textures, and `image` with what `level` of the view's texture shows of each point; NaN
/// where it does not show it. A point that faces the camera is compared with the plane of the pixel that it falls on;
/// any that the camera sees past, with the plane through the camera and the nearest rim of the silhouette. One item for
/// each point. Serial.
void associate_points(std::span<const motion::PosedPoint> points, const LayerView& view, int level,
                      const AssociationGates& gates, std::span<DataTerm> terms, std::span<float> image);

/// What each level of the view's texture shows where a point is; NaN where the layer is not measured there. Serial.
void sample_textures(std::span<const motion::PosedPoint> points, const LayerView& view,
                     std::span<std::array<float, LayerView::kLevels>> shown);

} // namespace kinora::tracking
