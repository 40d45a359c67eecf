// Frames that nothing was learnt of take their places in a finished clip.
#pragma once

#include <map>
#include <string>

#include "clip/clip.h"
#include "core/progress.h"
#include "encode/depth_alignment.h"
#include "ingest/capture/capture.h"

namespace kinora::encode {

/// Adds the frames of `held_out` to the clip's timeline, marked as such. Where the camera and the layers are in them is
/// interpolated between the frames beside and then aligned by depth with the fields as they are (align_by_depth), in
/// which layers are told apart by their depth: a frame's colour, labels and joints are not looked at. The joints of a
/// skeleton are interpolated. Fields, and all frames that the clip had, stay as they are.
/// `frames_know_camera`: the poses of the frames are given; else a camera that moves is found like a layer.
/// `stiffness`: by the name of each layer that deforms. Same bits for any number of threads. Throws what the capture
/// throws and Error(kInterrupted).
void add_held_out_frames(clip::Clip& clip, ingest::Capture& held_out, bool frames_know_camera,
                         const std::map<std::string, LayerStiffness>& stiffness, Progress& progress);

} // namespace kinora::encode
