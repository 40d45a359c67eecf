// Frames of a capture that are kept from everything that is made of it, so that it can be judged by them.
#pragma once

#include <functional>
#include <memory>

#include "core/frame_range.h"
#include "ingest/capture/capture.h"

namespace kinora::encode {

/// Frames `every`−1, 2·`every`−1, … of a range, wherever a frame in between cannot be read; none if `every` is 0.
struct HeldOutFrames {
  int every = 0;
  FrameRange range = {}; ///< of all frames that are used

  /// `index`: in the capture, within the range.
  bool contains(int index) const { return every > 0 && ((index - range.begin) / range.step + 1) % every == 0; }
  /// How many of `frames` of the range are not held out.
  int kept_of(int frames) const { return every > 0 ? frames - frames / every : frames; }
};

/// The frames of a capture for whose index `wanted` holds; others are read and dropped.
std::unique_ptr<ingest::Capture> frames_where(std::unique_ptr<ingest::Capture> capture,
                                              std::function<bool(int index)> wanted);

} // namespace kinora::encode
