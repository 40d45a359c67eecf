// Brings the path of a moving camera nearer to what the background shows: poses, tracked or given, err by a pixel or
// two, and a field that is trained with them is blurred by as much.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "clip/readout.h"
#include "encode/frame_pass.h"
#include "encode/layer_training.h"
#include "encode/pose_refinement.h"

namespace kinora::encode {

struct CameraRefinement {
  std::size_t frames = 0;       ///< that were brought nearer in the last pass
  double color_before = 0;      ///< typical difference (robust deviation, of 1) of field and pixels, mean over frames
  double color_after = 0;       ///< after the last pass
  double metres = 0;            ///< that a camera moved by, median over the frames
  double radians = 0;           ///< that it turned by
  clip::Readout readout;        ///< how long the rows of a picture are read
  std::vector<SE3> corrections; ///< of each frame of the timeline: from the world as tracked to the world
  FieldDraft draft;             ///< of the background, trained with the path before the last pass
};

/// Trains a draft of the still background and aligns each stored frame's camera to it, `passes` times. Frames that are
/// not stored, or would be explained no better, move as those beside them do. The path, the cameras of stored pixels
/// and whatever moves before the camera change alike, so that each frame looks as before from its camera. Nothing if
/// the camera stands still or no background is modelled. Same input, same bits, for any number of threads. Throws
/// Error(kInterrupted) when cancelled.
std::optional<CameraRefinement> refine_camera(FramePass& pass, const TrainingPlan& plan, const EncodeOptions& options,
                                              StageTimes& times, Progress& progress);

} // namespace kinora::encode
