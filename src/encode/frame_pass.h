// One pass over the frames of a capture: labels are followed, and pixels are kept for training.
#pragma once

#include <cstddef>
#include <map>
#include <optional>

#include "clip/clip.h"
#include "core/progress.h"
#include "encode/encode_options.h"
#include "encode/stage_times.h"
#include "encode/tracked_label.h"
#include "fields/sampling/pixel_store.h"
#include "ingest/capture/capture.h"

namespace kinora::encode {

/// What the pass leaves behind.
struct FramePass {
  clip::Clip clip;           ///< timeline, camera and its path; no layer yet
  fields::PixelStore pixels; ///< of all frames but those that are only tracked and those without mask
  std::map<int, TrackedLabel> labels;
  std::optional<double> depth_delay; ///< seconds (ingest::StreamDelay)
  std::size_t unlabelled = 0; ///< frames without mask in a capture with masks: tracked nowhere, trained on nowhere
};

/// Reads the capture to its end, which leaves out what nothing may see. The same bits for any number of threads. Throws
/// what the capture throws, Error(kCorruptInput) if no frame is usable, Error(kInterrupted).
FramePass pass_over_frames(ingest::Capture& capture, const EncodeOptions& options, StageTimes& times,
                           Progress& progress);

} // namespace kinora::encode
