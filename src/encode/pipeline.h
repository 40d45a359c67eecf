// From a prepared capture to a clip: one pass over the frames that tracks and remembers pixels, then one training per
// layer.
#pragma once

#include <nlohmann/json.hpp>

#include "clip/clip.h"
#include "core/progress.h"
#include "encode/capture_preparation.h"
#include "encode/encode_options.h"

namespace kinora::encode {

struct EncodeResult {
  clip::Clip clip;
  /// "kinora.encode/1": `capture` (what was read, skipped frames with reasons), `camera`,
  /// `streams` (exposure, delay and registration of colour and depth, as estimated), `layers` (what was modelled
  /// and why, parameters, tracking health, training, milliseconds per frame), `not_modelled`, `config`, `settings`,
  /// `timing`.
  nlohmann::json report;
};

/// Models what the capture shows and no more. Without labels everything is the still layer `background`; without
/// poses the camera is still. The capture is read to its end. Same capture and options, same clip, for any
/// number of threads; times are in the report alone. Memory: the stored pixels, one frame, a TSDF per rigid layer and
/// the field in training. Throws Error: kCorruptInput if no frame is usable, kFailure if nothing can be modelled,
/// kInterrupted.
EncodeResult encode_capture(PreparedCapture prepared, const EncodeOptions& options, Progress& progress);

} // namespace kinora::encode
