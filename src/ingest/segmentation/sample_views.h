// A few frames of a capture, spread over all of it.
#pragma once

#include <vector>

#include "ingest/frame/reduced_view.h"
#include "ingest/segmentation/segmenter.h"

namespace kinora::ingest {

/// At most 48 frames of the range, at equal distances. Throws what the capture throws.
std::vector<ReducedView> sample_views(const CaptureFactory& open, FrameRange range, Progress& progress);

} // namespace kinora::ingest
