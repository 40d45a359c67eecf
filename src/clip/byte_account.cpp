#include "clip/byte_account.h"

#include <algorithm>
#include <numeric>

#include "clip/clip_description.h"
#include "clip/stored_sound.h"

namespace kinora::clip {

static std::string account_name(const std::string& file) {
  if (file == kClipFile) return "timeline";
  if (file == kCalibrationFile) return "calibration";
  if (file == kMetadataFile || file == kCompressedMetadataFile) return "metadata";
  return "attachment " + file;
}

ByteAccount account_of(const container::Reader& reader, const std::map<std::uint16_t, std::size_t>& payloads,
                       const std::map<std::size_t, std::size_t>& media) {
  ByteAccount account;
  account.total = static_cast<std::size_t>(reader.file_bytes());
  for (const container::StoredTrack& track : reader.tracks()) {
    if (!track.ours) continue;
    const auto found = payloads.find(track.track.id);
    const std::size_t bytes = found == payloads.end() ? 0 : found->second;
    account.entries.push_back({track.track.name, bytes + track.track.private_data.size()});
  }
  for (const auto& [track, bytes] : media) {
    const container::StoredTrack& stored = reader.tracks()[track];
    const std::string& name = stored.track.name.empty() ? stored.track.codec : stored.track.name;
    account.entries.push_back({is_clip_sound(stored) ? container::kSoundName : name, bytes});
  }
  for (const container::StoredAttachment& stored : reader.attachments())
    account.entries.push_back({account_name(stored.name), static_cast<std::size_t>(stored.stored_bytes)});
  if (!reader.damage().empty())
    account.entries.push_back({"damaged", static_cast<std::size_t>(reader.damage().bytes())});
  const auto add = [](std::size_t sum, const ByteAccount::Entry& entry) { return sum + entry.bytes; };
  const std::size_t known = std::accumulate(account.entries.begin(), account.entries.end(), std::size_t{0}, add);
  account.entries.push_back({"container", account.total - std::min(account.total, known)});
  return account;
}

} // namespace kinora::clip
