#include "player/as_recorded.h"

#include "core/color_gain.h"
#include "fields/rendering/row_by_row.h"

namespace kinora::player {

AsRecorded::AsRecorded(const clip::Clip& clip, RecordingFaults faults) : capture_frames_(clip.capture_frames) {
  if (faults.exposure) exposure_ = clip::stored_exposure(clip.metadata);
  if (faults.rolling_shutter) readout_ = clip::readout_of_frames(clip);
}

void AsRecorded::apply_to(fields::Picture& picture, const Intrinsics& intrinsics, std::size_t frame) const {
  if (!readout_.empty()) {
    picture = fields::read_row_by_row(picture, intrinsics, readout_[frame].color, readout_[frame].depth);
  }
  if (!exposure_.empty()) GainTables(clip::gain_at(exposure_, capture_frames_[frame])).apply_to(picture.color);
}

} // namespace kinora::player
