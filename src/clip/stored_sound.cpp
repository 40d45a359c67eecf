#include "clip/stored_sound.h"

#include <algorithm>

namespace kinora::clip {

bool is_clip_sound(const container::StoredTrack& track) {
  return !track.ours && track.type == container::kSoundType && !track.encoded_again &&
         track.track.name != container::kCaptureSoundName;
}

StoredSound::StoredSound(const container::Reader& reader) {
  const auto& tracks = reader.tracks();
  const auto found = std::find_if(tracks.begin(), tracks.end(), is_clip_sound);
  if (found == tracks.end()) return;
  track_ = static_cast<std::size_t>(found - tracks.begin());
  sound_.track = found->track;
  sound_.track.id = container::kSoundTrack;
}

void StoredSound::take(container::Reader& reader, const container::StoredBlock& block, AllocationBudget& budget) {
  if (block.track != track_ || block.laced) return;
  budget.take(block.data_bytes, reader.name());
  sound_.packets.push_back({container::kSoundTrack, block.time_ns, true, reader.read_block(block)});
}

std::optional<container::Sound> StoredSound::gathered() && {
  if (sound_.packets.empty()) return std::nullopt;
  std::stable_sort(sound_.packets.begin(), sound_.packets.end(),
                   [](const container::Payload& a, const container::Payload& b) { return a.time_ns < b.time_ns; });
  return std::move(sound_);
}

} // namespace kinora::clip
