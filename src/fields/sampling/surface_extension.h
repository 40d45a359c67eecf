// Where colour was seen and no depth: the surfaces around go on.
#pragma once

#include <functional>

#include "ingest/frame/frame.h"

namespace kinora::fields {

/// Guesses of the depths, in metres along the optical axis, of the pixels with a label that have no clean depth; 0 at
/// all others, and everywhere if no pixel with the label has any. Sensors leave such holes where things are too near,
/// black or glossy, in the shadow of their projector and along the picture's border.
///
/// A pixel continues the plane (linear in inverse depth) of the surface from which it is reached along the shortest
/// path, where colours that change make a path longer: the nearest surface that looks the same. Where several
/// neighbours say nearly the same, their mean is taken. In pictures of 640 pixels to a side or more this is done by
/// square cells, about 320 of them along the longer side: a pixel in a cell with a clean depth stays 0 there, too.
/// Nothing is guessed far before the nearest or behind the farthest depth of the frame. Holes (pixels that hang
/// together, also by corners) of which no pixel is wanted are left out: they stay 0, and all others are as if they had
/// not been. Thread-safe.
DepthImage extend_surfaces(
    const ingest::Frame& frame, std::uint8_t label,
    const std::function<bool(int u, int v)>& is_wanted = [](int /*u*/, int /*v*/) { return true; });

} // namespace kinora::fields
