// A view as another camera would have seen it.
#pragma once

#include "ingest/frame/reduced_view.h"

namespace kinora::ingest {

/// What a view shows, as another camera would have seen it at that moment. Surfaces are drawn as register_depth draws
/// them; where nothing was measured and nothing stands in front, the view is taken for infinitely far.
/// From the view's own camera: the view itself.
ReducedView reproject(const Camera& camera, const ReducedView& view);

} // namespace kinora::ingest
