// A picture drawn small, made larger.
#pragma once

#include "fields/rendering/renderer.h"

namespace kinora::fields {

/// Colours are interpolated bilinearly, weighted by opacity; depth too, but not across an edge, where it is the nearest
/// pixel's, as `front` and normals are. Same bits for any number of threads.
Picture upsampled(const Picture& small, int width, int height);

} // namespace kinora::fields
