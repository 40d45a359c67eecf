// Labels that a segmenter told from the room, and that tracking then could not follow: no layer is made of them.
#pragma once

#include "encode/frame_pass.h"
#include "encode/training_plan.h"

namespace kinora::encode {

/// The share of a label's measured pixels whose place and colour other frames show again: their depth agrees within
/// what a sensor tells, or what they see behind that place has the same colour (far depth is noisy). Of those alone
/// before which nothing else stands. 1 for what keeps still, lower for what goes away from before something of another
/// colour. Looks at up to eight frames of the store, spread over those that show the label. 0 if no pair of frames
/// tells.
double still_share(const fields::PixelStore& pixels, int label);

/// Takes from `pass` every label that moves, that a segmenter found (LabelInfo::why), not a mask, and that is lost in
/// more than half of the stored frames that show it. Where its still_share is at least one half the room explains it,
/// and its pixels become the room's (label 0); else they are trained on nowhere. Returns the labels with their reasons.
std::vector<NotModelled> drop_lost_labels(FramePass& pass, const ingest::CaptureInfo& capture);

} // namespace kinora::encode
