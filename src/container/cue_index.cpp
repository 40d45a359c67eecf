#include "container/cue_index.h"

#include <algorithm>
#include <map>
#include <utility>

#include "container/ebml.h"
#include "container/matroska_ids.h"
#include "core/error.h"

namespace kinora::container {
namespace {

constexpr std::uint64_t kMaxIndexBytes = 4 << 20;
constexpr double kUsualTick = 1e-3; // seconds
constexpr double kHalfTick = 5e-4;  // times in the index are rounded

/// What the front of a file says of its index.
struct Front {
  std::uint64_t segment = 0; // byte from which positions count
  std::optional<std::uint64_t> index;
  double tick = kUsualTick; // seconds
};

// Calls visit(child) for those that are there whole.
template <class Visit>
void for_each_whole_child(ByteSource& source, std::uint64_t begin, std::uint64_t end, const Visit& visit) {
  for (std::uint64_t at = begin; at < end;) {
    const Element child = read_element_header(source, at, end);
    if (child.unknown_size || child.end > end) return;
    visit(child);
    at = child.end;
  }
}

std::uint64_t number_in(ByteSource& source, const Element& parent, std::uint32_t id, std::uint64_t otherwise) {
  std::uint64_t number = otherwise;
  for_each_child(source, parent, [&](const Element& child) {
    if (child.id == id) number = read_uint(source, child);
  });
  return number;
}

void read_segment_head(ByteSource& head, Front& front) {
  for_each_whole_child(head, front.segment, head.size(), [&](const Element& child) {
    if (child.id == ids::kInfo) {
      front.tick = 1e-9 * static_cast<double>(number_in(head, child, ids::kTimestampScale, 1'000'000));
    }
    if (child.id != ids::kSeekHead) return;
    for_each_child(head, child, [&](const Element& seek) {
      if (seek.id != ids::kSeek || number_in(head, seek, ids::kSeekId, 0) != ids::kCues) return;
      const std::uint64_t position = number_in(head, seek, ids::kSeekPosition, 0);
      if (position > 0) front.index = front.segment + position;
    });
  });
}

Front front_of(ByteSource& head) {
  Front front;
  for (std::uint64_t at = 0;;) {
    const Element element = read_element_header(head, at, head.size());
    if (element.id == ids::kSegment) {
      front.segment = element.body;
      break;
    }
    if (element.end > head.size()) return front;
    at = element.end;
  }
  try {
    read_segment_head(head, front);
  } catch (const Error&) { // where the head ends
  }
  return front;
}

} // namespace

std::optional<CueIndex> CueIndex::read(std::span<const std::byte> head, ByteSource& file) {
  Front front;
  try {
    MemorySource source(head, file.name());
    front = front_of(source);
  } catch (const Error&) {
    return std::nullopt;
  }
  if (!front.index || *front.index >= file.size() || file.size() - *front.index > kMaxIndexBytes) return std::nullopt;
  std::vector<std::byte> bytes(static_cast<std::size_t>(file.size() - *front.index));
  file.read(*front.index, bytes);
  std::map<std::uint64_t, std::vector<Cue>> tracks;
  try {
    MemorySource source(bytes, file.name());
    const Element cues = read_element(source, 0, source.size());
    if (cues.id != ids::kCues) return std::nullopt;
    for_each_child(source, cues, [&](const Element& point) {
      if (point.id != ids::kCuePoint) return;
      const double seconds = static_cast<double>(number_in(source, point, ids::kCueTime, 0)) * front.tick;
      for_each_child(source, point, [&](const Element& positions) {
        if (positions.id != ids::kCueTrackPositions) return;
        const std::uint64_t cluster = front.segment + number_in(source, positions, ids::kCueClusterPosition, 0);
        if (cluster >= file.size()) return;
        tracks[number_in(source, positions, ids::kCueTrack, 0)].push_back({seconds, cluster});
      });
    });
  } catch (const Error&) {
    return std::nullopt;
  }
  CueIndex index;
  index.file_bytes_ = file.size();
  for (auto& [track, cues] : tracks) {
    if (cues.size() < 2) continue; // it is of no time, or can be entered at its beginning alone
    std::stable_sort(cues.begin(), cues.end(), [](const Cue& a, const Cue& b) { return a.seconds < b.seconds; });
    index.tracks_.push_back(std::move(cues));
  }
  if (index.tracks_.empty()) return std::nullopt;
  return index;
}

ByteRange CueIndex::bytes_for(double seconds) const {
  ByteRange range{file_bytes_, file_bytes_};
  std::uint64_t last = 0;
  for (const std::vector<Cue>& cues : tracks_) {
    const auto after = std::upper_bound(cues.begin(), cues.end(), seconds + kHalfTick,
                                        [](double time, const Cue& cue) { return time < cue.seconds; });
    const Cue& before = after == cues.begin() ? cues.front() : *(after - 1);
    range.begin = std::min(range.begin, before.cluster);
    last = std::max(last, before.cluster);
  }
  for (const std::vector<Cue>& cues : tracks_) {
    for (const Cue& cue : cues) {
      if (cue.cluster > last) range.end = std::min(range.end, cue.cluster);
    }
  }
  return range;
}

} // namespace kinora::container
