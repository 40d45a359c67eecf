// From a capture that goes on to a clip that grows beside it, on two threads: the front end follows every frame as it
// comes and never waits; the trainer works on the key frames and the motion that there are (Jiang et al.,
// "Instant-NVR", CVPR 2023, fig. 2).
#pragma once

#include <functional>
#include <optional>

#include "encode/live/live_trainer.h"
#include "encode/pipeline.h"

namespace kinora::encode {

struct LiveRequest {
  /// Called now and then with the clip as it is, and last with the clip as it stays. On the trainer's thread.
  std::function<void(const clip::Clip&)> publish;
  double interval = 1; ///< seconds between two calls, at least; they take no more than a tenth of the time
  /// Seconds of training after the last frame, unless the user stopped: more or less, as a round lasts.
  double after_end = 2;
  /// Camera to world of who looks at the clip, if anybody does: called on the trainer's thread before each publishing,
  /// which the fields are refined for. May be empty.
  std::function<std::optional<SE3>()> asked_view;
};

/// What becomes of it depends on the speed of the machine. Everything is done with what is known by then: nothing looks
/// ahead (Settings::live). Without masks the first second is watched, and no frame of it is followed
/// (ingest::live_segmented_capture). The camera is still, or the frames say where it is. The report is that of
/// encode_capture, with `live`: frames that were followed and lost, seconds from capture to motion, rounds of
/// training, and what became of frames as key frames. The first Ctrl-C ends the capture: that is no error here. Throws
/// what the capture and `publish` throw, and Error: kCorruptInput if no frame is usable, kFailure if nothing can be
/// modelled.
EncodeResult encode_live(ingest::Capture& capture, const LiveRequest& request, const EncodeOptions& options,
                         Progress& progress);

} // namespace kinora::encode
