// A spread of what was measured of a layer, in its canonical space: what is chosen before training is chosen from.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "fields/sampling/layer_observations.h"

namespace kinora::fields {

struct LayerPoint {
  Eigen::Vector3d canonical;      ///< metres
  Eigen::Vector3d towards_camera; ///< unit vector in canonical space
  double footprint;               ///< metres of a pixel at the point
  double pixels;                  ///< of its frame for which it stands
  std::size_t frame;              ///< index into PixelStore::frames()
};

/// At most about `max_points` of the layer's pixels with measured depth, evenly spread over all frames; none of frames
/// in which the layer is lost, or where no way back is found.
std::vector<LayerPoint> measured_points(const LayerObservations& layer, std::size_t max_points);

/// The same of those whose depth is measured or extended: all the space in which the layer is drawn.
std::vector<LayerPoint> measured_and_extended_points(const LayerObservations& layer, std::size_t max_points);

} // namespace kinora::fields
