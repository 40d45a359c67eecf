// How bright each frame was recorded beside the others: automatic exposure and white balance.
#pragma once

#include "clip/exposure.h"
#include "core/progress.h"
#include "encode/frame_pass.h"

namespace kinora::encode {

/// Gains of the frames whose pixels were kept, from what several of them show of the background: measured points are
/// carried from frame to frame, and the median log ratios of their light, per colour, are brought into agreement by
/// least squares. Their geometric mean is 1. Nothing if no gain differs from 1 by more than 3 %: exposure was even, or
/// it cannot be told. The same bits for any number of threads.
clip::Exposure measure_exposure(const FramePass& pass);

/// As if all frames had been recorded with the same exposure.
void take_out(const clip::Exposure& exposure, FramePass& pass);

} // namespace kinora::encode
