#include "clip/stored_sound.h"

#include <algorithm>

namespace kinora::clip {

bool is_clip_sound(const container::StoredTrack& track) {
  return !track.ours && track.type == container::kSoundType && !track.encoded_again &&
         track.track.name != container::kCaptureSoundName;
}

namespace {

/// Packets that shared a block have its time: they follow each other up to the next block's, as all are of one length.
void spread_times(std::vector<container::Payload>& packets) {
  std::int64_t length = 0; // of a packet of the block before
  for (std::size_t begin = 0, end = 0; begin < packets.size(); begin = end) {
    while (end < packets.size() && packets[end].time_ns == packets[begin].time_ns) ++end;
    const auto count = static_cast<std::int64_t>(end - begin);
    if (end < packets.size()) length = (packets[end].time_ns - packets[begin].time_ns) / count;
    for (std::int64_t i = 1; i < count; ++i) packets[begin + static_cast<std::size_t>(i)].time_ns += i * length;
  }
}

} // namespace

StoredSound::StoredSound(const container::Reader& reader) {
  const auto& tracks = reader.tracks();
  const auto found = std::find_if(tracks.begin(), tracks.end(), is_clip_sound);
  if (found == tracks.end()) return;
  track_ = static_cast<std::size_t>(found - tracks.begin());
  sound_.track = found->track;
  sound_.track.id = container::kSoundTrack;
}

void StoredSound::take(container::Reader& reader, const container::StoredBlock& block, AllocationBudget& budget) {
  if (block.track != track_) return;
  budget.take(block.data_bytes, reader.name());
  for (container::Bytes& packet : reader.read_frames(block))
    sound_.packets.push_back({container::kSoundTrack, block.time_ns, true, std::move(packet)});
}

std::optional<container::Sound> StoredSound::gathered() && {
  if (sound_.packets.empty()) return std::nullopt;
  std::stable_sort(sound_.packets.begin(), sound_.packets.end(),
                   [](const container::Payload& a, const container::Payload& b) { return a.time_ns < b.time_ns; });
  spread_times(sound_.packets);
  return std::move(sound_);
}

} // namespace kinora::clip
