// What a layer's training pixels say about how well it was seen.
#pragma once

#include "fields/model/confidence.h"
#include "fields/sampling/layer_observations.h"

namespace kinora::fields {

/// Looks at a spread of the layer's measured pixels; each counts for those of its frame that it stands for. Same bits
/// for any number of threads. Takes some ten milliseconds.
Confidence view_confidence(const LayerObservations& layer, const Field& field);

} // namespace kinora::fields
