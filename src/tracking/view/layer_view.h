// What one frame shows of a deforming layer, which may be the frame as a whole.
#pragma once

#include "tracking/view/object_view.h"

namespace kinora::tracking {

/// As view_object; a frame without labels is the layer's as a whole, one without a picture shows nothing.
ObjectView view_layer(const ingest::Frame& frame, int label);

/// Area of the surface that the view measures, metres².
double measured_area(const ObjectView& view);

} // namespace kinora::tracking
