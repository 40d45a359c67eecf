// A drawn picture as a camera with a rolling shutter would have recorded it.
#pragma once

#include "core/rolling_shutter.h"
#include "fields/rendering/renderer.h"

namespace kinora::fields {

/// `picture` was drawn as if all rows were read at once, in the middle of the time that reading takes; meanwhile the
/// camera moves by `color`, in its own space, and while the rows of depth are read by `depth`. Each pixel is looked up
/// where its row saw it, by the depth that is drawn there, the nearest of what it may be; what lies behind an edge in
/// the picture goes on from beside it. Depth and normals are of the row's own camera; all but depth are read as colour
/// is.
Picture read_row_by_row(const Picture& picture, const Intrinsics& intrinsics, const Twist& color, const Twist& depth);

} // namespace kinora::fields
