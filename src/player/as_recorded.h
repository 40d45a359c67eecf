// From what a clip shows from the capture's camera to what that camera recorded.
#pragma once

#include <cstddef>
#include <vector>

#include "clip/clip.h"
#include "clip/exposure.h"
#include "clip/readout.h"
#include "fields/rendering/renderer.h"

namespace kinora::player {

/// Which faults of the camera are put back.
struct RecordingFaults {
  bool exposure = false;        ///< each frame as bright, and as white, as it was recorded
  bool rolling_shutter = false; ///< each row as of the moment when it was read
};

/// Immutable, so thread-safe.
class AsRecorded {
public:
  AsRecorded(const clip::Clip& clip, RecordingFaults faults);
  /// `picture`: of a frame of the clip, drawn by the capture's camera, in any size.
  void apply_to(fields::Picture& picture, const Intrinsics& intrinsics, std::size_t frame) const;

private:
  std::vector<int> capture_frames_;
  clip::Exposure exposure_;
  std::vector<clip::ReadoutMotion> readout_; ///< of each frame; empty: rows are of one moment
};

} // namespace kinora::player
