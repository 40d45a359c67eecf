// The sound of a clip out of its file.
#pragma once

#include <optional>

#include "clip/coding/allocation_budget.h"
#include "container/reader.h"
#include "container/sound.h"

namespace kinora::clip {

/// Sound of whichever program, but not that of a recording beside the clip.
bool is_clip_sound(const container::StoredTrack& track);

/// Gathers the packets of the first track of sound.
class StoredSound {
public:
  explicit StoredSound(const container::Reader& reader);

  /// Blocks of other tracks are passed over. Throws Error(kCorruptInput) if it would take too much memory.
  void take(container::Reader& reader, const container::StoredBlock& block, AllocationBudget& budget);
  /// With the packets in the order of time; nothing if there are none.
  std::optional<container::Sound> gathered() &&;

private:
  std::optional<std::size_t> track_; ///< place in Reader::tracks()
  container::Sound sound_;
};

} // namespace kinora::clip
