// Flat faces of things that people hold: where a box is cut out of the one who carries it.
#pragma once

#include "ingest/images/surface_components.h"

namespace kinora::ingest {

struct FlatFaceSearch {
  double min_radius = 0.045;   ///< metres: a disc of this radius fits into a face; limbs are narrower
  double max_area = 0.5;       ///< square metres
  double min_free_edge = 0.45; ///< share of a face's rim beyond which the scene lies farther away, or bends
};

/// Pixels of `foreground` that belong to flat faces, 0 or 1. A face grows from a small plane over pixels that lie on
/// it within the noise. What ends in itself is a face of a thing; what bends away on all sides is a body. Faces that
/// touch such a face are added to it. Thread-safe.
Mask flat_faces(const DepthImage& depth, const Mask& foreground, const Intrinsics& intrinsics,
                const FlatFaceSearch& search = {});

} // namespace kinora::ingest
