// What one frame shows of a deforming layer, which may be the frame as a whole.
#pragma once

#include "tracking/view/layer_view.h"

namespace kinora::tracking {

/// As view_label; a frame without labels is the layer's as a whole, one without a picture shows nothing.
LayerView view_layer(const ingest::Frame& frame, int label);

/// Area of the surface that the view measures, metres².
double measured_area(const LayerView& view);

} // namespace kinora::tracking
