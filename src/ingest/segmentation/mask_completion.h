// Labels for the frames of a capture with masks that have none of their own.
#pragma once

#include <memory>

#include "ingest/segmentation/segmenter.h"

namespace kinora::ingest {

/// Keeps the masks that are there. In a frame without one the labels of the frame before are moved with the picture;
/// where that is not sure GrabCut decides, with the colours that each label has in the last frame with a mask (before
/// the first one: in that). A label stays on the surfaces that it was on: pieces elsewhere of the same colours do not
/// get it. Its `open` must read masks; frames stay unlabelled if no frame has a mask.
std::unique_ptr<Segmenter> make_mask_completion();

} // namespace kinora::ingest
