// Frames that nothing was learnt of take their places in a finished clip.
#pragma once

#include <optional>
#include <vector>

#include "clip/clip.h"
#include "core/progress.h"
#include "ingest/capture/capture.h"

namespace kinora::encode {

/// Adds the frames of `held_out` to the clip's timeline, marked as such. Where layers, joints and the camera are in
/// them lies on a smooth path through the two frames before and the two after (path_support, pose_on_path): of a
/// held-out frame only its time is looked at, and its camera where frames know it: `camera_corrections` says how the
/// cameras of the clip's frames were moved since (empty: not at all), and is nothing if frames do not know it. What was
/// lost in a frame beside is lost; all else counts as held. Fields, and all frames that the clip had, stay as they are.
/// Throws what the capture throws and Error(kInterrupted).
void add_held_out_frames(clip::Clip& clip, ingest::Capture& held_out,
                         const std::optional<std::vector<SE3>>& camera_corrections, Progress& progress);

} // namespace kinora::encode
