#include "container/reader.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "container/crc32c.h"
#include "container/envelope.h"
#include "container/matroska_ids.h"
#include "container/resync.h"
#include "container/stored_head.h"
#include "core/error.h"

namespace kinora::container {

namespace {

constexpr std::uint64_t kMaxHeaderBytes = 12; // identifier and size
constexpr std::uint64_t kBlockTimeAndFlags = 3;
constexpr std::uint8_t kLacingBits = 0x06;
constexpr std::uint8_t kKeyBit = 0x80; // of a SimpleBlock
// Bytes that looking for a sound payload may cost in checksums: a hostile file offers many false beginnings.
constexpr std::uint64_t kResyncEffort = 4; // times the file's
constexpr std::uint64_t kClusterEffort = 1 << 24;

[[noreturn]] void not_recognised(const ByteSource& source, const std::string& why) {
  throw Error(ErrorCode::kNotRecognised, fmt::format("{} is not a Kinora file: {}", source.name(), why));
}

} // namespace

Reader::Reader(const std::filesystem::path& path, Reading reading)
    : Reader(std::make_unique<FileSource>(path), reading) {}

Reader::Reader(std::unique_ptr<ByteSource> source, Reading reading) : source_(std::move(source)), reading_(reading) {
  read_ebml_head();
  find_segment();
  scan_segment();
  check_tracks();
}

void Reader::check_tracks() {
  std::set<std::uint16_t> track_ids;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    // What is salvaged goes by the first; blocks of the other are known by their envelopes.
    if (!track_indices_.emplace(tracks_[i].number, i).second && reading_ != Reading::kSalvage) {
      throw_corrupt(*source_, segment_.start, fmt::format("two tracks have the number {}", tracks_[i].number));
    }
    if (tracks_[i].ours && !track_ids.insert(tracks_[i].track.id).second) {
      throw_corrupt(*source_, segment_.start, fmt::format("two tracks have the id {}", tracks_[i].track.id));
    }
  }
}

void Reader::read_ebml_head() {
  constexpr std::array<std::byte, 4> kMagic{std::byte{0x1A}, std::byte{0x45}, std::byte{0xDF}, std::byte{0xA3}};
  std::array<std::byte, 4> magic{};
  if (source_->size() < magic.size()) not_recognised(*source_, fmt::format("it has {} bytes", source_->size()));
  source_->read(0, magic);
  if (magic != kMagic) not_recognised(*source_, "it does not begin as Matroska does");

  const Element head = read_element(*source_, 0, source_->size());
  if (head.unknown_size) throw_corrupt(*source_, 0, "the EBML header has no size");
  std::string doc_type;
  for_each_child(*source_, head, [&](const Element& child) {
    const auto limit = [&](std::uint64_t max_value, const char* what) {
      const std::uint64_t value = read_uint(*source_, child);
      if (value > max_value)
        not_recognised(*source_, fmt::format("its {} is {}; this Kinora reads up to {}", what, value, max_value));
    };
    if (child.id == ids::kDocType) doc_type = read_text(*source_, child);
    if (child.id == ids::kEbmlReadVersion) limit(1, "EBML version");
    if (child.id == ids::kEbmlMaxIdLength) limit(4, "longest EBML identifier");
    if (child.id == ids::kEbmlMaxSizeLength) limit(8, "longest EBML size");
    if (child.id == ids::kDocTypeReadVersion) limit(4, "Matroska version");
  });
  // WebM is a part of Matroska.
  if (doc_type != "matroska" && doc_type != "webm") not_recognised(*source_, "its document type is not matroska");
  position_ = head.end;
}

void Reader::find_segment() {
  for (;;) {
    segment_ = read_element_header(*source_, position_, source_->size());
    if (segment_.id == ids::kSegment) break;
    position_ = read_element(*source_, position_, source_->size()).end; // Void
  }
  truncated_ = segment_.end > source_->size();
  segment_.end = std::min(segment_.end, source_->size());
  position_ = segment_.body;
}

// An element in the segment or in an open cluster. Its end lies beyond the segment's only if the file was cut there.
Element Reader::element_at(std::uint64_t offset) {
  const bool may_be_cut = truncated_ || segment_.unknown_size || reading_ != Reading::kStrict;
  Element element;
  try {
    element = read_element_header(*source_, offset, segment_.end);
  } catch (const Error&) {
    if (!may_be_cut || segment_.end - offset >= kMaxHeaderBytes) throw;
    element = {0, offset, segment_.end, segment_.end + 1, false}; // the cut goes through this header
  }
  if (element.end > segment_.end && !may_be_cut) read_element(*source_, offset, segment_.end); // says so
  if (element.end > segment_.end && reading_ != Reading::kSalvage) truncated_ = true;
  if (element.unknown_size && element.id != ids::kCluster) {
    throw_corrupt(*source_, offset, "an element of unknown size where none may be");
  }
  return element;
}

void Reader::scan_segment() {
  for (std::uint64_t at = segment_.body; at < segment_.end;) {
    const std::uint64_t start = at;
    try {
      const Element element = element_at(at);
      if (reading_ == Reading::kSalvage) check_plausible(element, segment_.end);
      if (element.end > segment_.end) break;
      at = element.unknown_size ? end_of_open_cluster(element) : element.end;
      scan_element(element);
    } catch (const Error& error) {
      if (reading_ != Reading::kSalvage || error.code() != ErrorCode::kCorruptInput) throw;
      if (at > start) {
        damage_.add(start, at, error.what());
      } else { // next() will come here again and say so
        at = find_sync(*source_, start + 1, segment_.end, [](const Element&) { return false; });
      }
    }
  }
  if (tracks_.empty()) throw_corrupt(*source_, segment_.end, "the file ends without a list of tracks");
}

// The same element may stand in a file twice (RFC 9559, section 5.1); the first counts.
void Reader::scan_element(const Element& element) {
  const auto damaged = [this](const Element& entry, const Error& error) {
    if (reading_ != Reading::kSalvage) throw Error(error);
    damage_.add(entry.start, entry.end, error.what());
  };
  if (element.id == ids::kTracks && tracks_.empty()) {
    parse_tracks(*source_, element, damaged, tracks_);
    if (tracks_.empty()) throw_corrupt(*source_, element.start, "a list of tracks without a track");
  }
  if (element.id == ids::kInfo) {
    for_each_child(*source_, element, [this](const Element& child) {
      if (child.id == ids::kTimestampScale) timestamp_scale_ = std::max<std::uint64_t>(1, read_uint(*source_, child));
    });
  }
  if (element.id == ids::kAttachments && attachments_.empty()) {
    parse_attachments(*source_, element, damaged, attachments_);
  }
  if (element.id == ids::kChapters && chapters_.empty()) parse_chapters(*source_, element, chapters_);
  if (element.id == ids::kTags && tags_.empty()) parse_tags(*source_, element, tags_);
}

std::uint64_t Reader::end_of_open_cluster(const Element& cluster) {
  for (std::uint64_t at = cluster.body; at < segment_.end;) {
    const Element child = element_at(at);
    if (ids::ends_cluster(child.id)) return at;
    at = child.end;
  }
  return segment_.end;
}

std::optional<std::string> Reader::tag(std::string_view tag_name) const {
  for (const auto& [name, value] : tags_) {
    if (name == tag_name) return value;
  }
  return std::nullopt;
}

const StoredAttachment* Reader::find_attachment(std::string_view attachment_name) const {
  for (const StoredAttachment& attachment : attachments_) {
    if (attachment.name == attachment_name) return &attachment;
  }
  return nullptr;
}

Bytes Reader::read_attachment(const StoredAttachment& attachment) {
  Bytes bytes = read_bytes(*source_, attachment.data);
  if (attachment.checksum && *attachment.checksum != crc32c(bytes)) {
    throw_corrupt(
        *source_, attachment.data.start,
        fmt::format("attachment {} does not match its checksum; the file is damaged, fetch it again", attachment.name));
  }
  return bytes;
}

bool Reader::next(Payload& payload) {
  StoredBlock block;
  while (next_block(block)) {
    if (!tracks_[block.track].ours) continue;
    payload = read_payload(block);
    return true;
  }
  return false;
}

bool Reader::next_block(StoredBlock& block) {
  for (;;) {
    bool found = false;
    try {
      while (!found) {
        if (!step(block, found)) return false;
      }
      if (reading_ == Reading::kSalvage && tracks_[block.track].ours) read_payload(block);
      return true;
    } catch (const Error& error) {
      if (reading_ != Reading::kSalvage || error.code() != ErrorCode::kCorruptInput) throw;
      const std::uint64_t start = found ? block.offset : position_;
      position_ = position_after_failure(start, found ? block.offset + block.stored_bytes : start);
      damage_.add(start, position_, error.what());
    }
  }
}

// One element further; false at the end. position_ is moved only over what was understood.
bool Reader::step(StoredBlock& block, bool& found) {
  if (position_ >= cluster_end_) return enter_cluster();
  const std::uint64_t limit = std::min(cluster_end_, segment_.end);
  if (reading_ == Reading::kFollow && is_incomplete(position_)) return false;
  if (position_ >= limit) return at_end();
  const bool may_end_here = cluster_is_open_ || reading_ == Reading::kSalvage;
  if (may_end_here && ids::ends_cluster(read_element_header(*source_, position_, limit).id)) {
    cluster_end_ = position_;
    return true;
  }
  const Element element = read_element(*source_, position_, limit);
  if (element.unknown_size) throw_corrupt(*source_, position_, "an element of unknown size where none may be");
  // Blocks must name a track that is listed; a cluster's time must be there, whatever follows it.
  const bool speaks_for_itself =
      ids::is_block(element.id) || (element.id == ids::kTimestamp && element.body_size() <= 8);
  if (reading_ == Reading::kSalvage && !speaks_for_itself) check_plausible(element, limit);
  if (element.id == ids::kTimestamp) cluster_time_ = read_uint(*source_, element);
  if (element.id == ids::kSimpleBlock || element.id == ids::kBlock) { // the latter where a group's head was lost
    take_block(element, element, block);
    found = true;
  }
  if (element.id == ids::kBlockGroup) found = take_group(element, block);
  position_ = element.end;
  return true;
}

// While a file is written: the element at `offset` is not there to its end.
bool Reader::is_incomplete(std::uint64_t offset) {
  if (offset >= segment_.end) return true;
  try {
    const Element element = read_element_header(*source_, offset, segment_.end);
    return !element.unknown_size && element.end > segment_.end && element.id != ids::kCluster;
  } catch (const Error&) {
    if (segment_.end - offset < kMaxHeaderBytes) return true;
    throw;
  }
}

bool Reader::at_end() {
  if (truncated_ && reading_ == Reading::kStrict) {
    throw_corrupt(*source_, segment_.end, "the file is cut short here; fetch it again");
  }
  return false;
}

bool Reader::enter_cluster() {
  while (position_ < segment_.end) {
    if (reading_ == Reading::kFollow && is_incomplete(position_)) return false;
    const Element element = element_at(position_);
    if (reading_ == Reading::kSalvage) {
      check_plausible(element, segment_.end);
      if (ids::is_block(element.id)) throw_corrupt(*source_, position_, "a block outside of a cluster");
    }
    if (element.id == ids::kCluster) {
      position_ = element.body;
      const bool growing = reading_ == Reading::kFollow && !element.unknown_size;
      cluster_end_ = growing ? element.end : std::min(element.end, segment_.end);
      cluster_is_open_ = element.unknown_size;
      if (cluster_is_open_ && reading_ == Reading::kFollow) cluster_end_ = std::numeric_limits<std::uint64_t>::max();
      return true;
    }
    if (element.end > segment_.end) break;
    position_ = element.end;
  }
  return at_end();
}

bool Reader::take_group(const Element& group, StoredBlock& out) {
  Element block;
  bool refers = false;
  for_each_child(*source_, group, [&](const Element& child) {
    if (child.id == ids::kBlock && block.id == 0) block = child;
    refers = refers || child.id == ids::kReferenceBlock;
  });
  if (block.id != 0) take_block(block, group, out);
  out.key = !refers;
  return block.id != 0;
}

void Reader::take_block(const Element& block, const Element& whole, StoredBlock& out) {
  const VariableInteger number = read_variable_integer(*source_, block.body, block.end);
  const std::uint64_t rest = block.body_size() - static_cast<std::uint64_t>(number.length);
  const auto index = track_indices_.find(number.value);
  if (index == track_indices_.end()) {
    throw_corrupt(*source_, block.start,
                  fmt::format("a block of track {}, which the file does not list", number.value));
  }
  if (rest < kBlockTimeAndFlags) throw_corrupt(*source_, block.start, "a block without time and flags");
  std::array<std::byte, kBlockTimeAndFlags> head{};
  source_->read(block.end - rest, head);
  const auto relative = static_cast<std::int16_t>(std::to_integer<unsigned>(head[0]) << 8 |
                                                  std::to_integer<unsigned>(head[1])); // of the cluster
  out.track = index->second;
  out.time_ns = static_cast<std::int64_t>((cluster_time_ + static_cast<std::uint64_t>(relative)) * timestamp_scale_);
  out.data = block.end - rest + kBlockTimeAndFlags;
  out.data_bytes = block.end - out.data;
  out.offset = whole.start;
  out.stored_bytes = whole.total_size();
  out.key = (std::to_integer<std::uint8_t>(head[2]) & kKeyBit) != 0;
  out.lacing = static_cast<Lacing>((std::to_integer<std::uint8_t>(head[2]) & kLacingBits) >> 1);
  if (out.lacing != Lacing::kNone && tracks_[out.track].ours) {
    throw_corrupt(*source_, block.start, "payloads that share a block (lacing); remux with mkvmerge --disable-lacing");
  }
}

Bytes Reader::read_block(const StoredBlock& block) {
  Bytes bytes = tracks_[block.track].stripped_prefix;
  const std::size_t prefix = bytes.size();
  bytes.resize(prefix + static_cast<std::size_t>(block.data_bytes));
  source_->read(block.data, std::span(bytes).subspan(prefix));
  return bytes;
}

std::vector<Bytes> Reader::read_frames(const StoredBlock& block) {
  Bytes data(static_cast<std::size_t>(block.data_bytes));
  source_->read(block.data, data);
  const Bytes& prefix = tracks_[block.track].stripped_prefix;
  std::vector<Bytes> frames;
  for (const std::span<const std::byte> frame : laced_frames(data, block.lacing)) {
    Bytes& bytes = frames.emplace_back(prefix);
    bytes.insert(bytes.end(), frame.begin(), frame.end());
  }
  return frames;
}

Payload Reader::read_payload(const StoredBlock& block) {
  if (block.data_bytes > max_payload_bytes_) {
    throw_corrupt(*source_, block.offset,
                  fmt::format("a payload of {} bytes, and {} are the most", block.data_bytes, max_payload_bytes_));
  }
  Payload payload = unwrap_payload(tracks_[block.track].track.id, read_block(block),
                                   fmt::format("{}: byte {}", name(), block.offset));
  payload.offset = block.offset;
  payload.stored_bytes = block.stored_bytes;
  return payload;
}

// An element that nobody knows is believed if one that is known follows.
void Reader::check_plausible(const Element& element, std::uint64_t limit) {
  if (is_plausible_element(*source_, element.start, limit) || is_plausible_top_level(*source_, element.start, limit) ||
      (element.end <= limit && is_plausible_element(*source_, element.end, limit))) {
    return;
  }
  throw_corrupt(*source_, element.start, "not an element that may stand here; the file is damaged");
}

// Where to go on behind an element at `start` that cannot be used, and which seems to end at `end` (or at `start`,
// where nothing is known): there, if that looks sound, else wherever a cluster or a payload of ours with its checksum
// begins.
std::uint64_t Reader::position_after_failure(std::uint64_t start, std::uint64_t end) {
  const std::uint64_t limit = std::min(cluster_end_, segment_.end);
  if (end > start && end < limit && is_plausible_element(*source_, end, limit)) return end;
  if (end > start && end == limit && (limit == segment_.end || is_plausible_top_level(*source_, end, segment_.end))) {
    return end;
  }
  const std::uint64_t from = end > start || start == last_failure_ ? start + 1 : start;
  last_failure_ = start;
  std::uint64_t sound_end = 0;
  std::uint64_t sound_time = cluster_time_; // what the cluster's must be for a sound payload's to be right
  const std::uint64_t effort_limit = kResyncEffort * source_->size() + kClusterEffort;
  const std::uint64_t found = find_sync(*source_, from, segment_.end, [&](const Element& element) {
    if (resync_effort_ > effort_limit) return false;
    try {
      StoredBlock block;
      take_block(element, element, block);
      if (!tracks_[block.track].ours || block.data_bytes < kEnvelopeBytes) return false;
      resync_effort_ += block.data_bytes;
      const Payload payload = read_payload(block);
      const std::uint64_t relative = static_cast<std::uint64_t>(block.time_ns) / timestamp_scale_ - cluster_time_;
      sound_time = (static_cast<std::uint64_t>(payload.time_ns) + timestamp_scale_ / 2) / timestamp_scale_ - relative;
      sound_end = element.end;
      return true;
    } catch (const Error&) {
      return false;
    }
  });
  if (is_plausible_top_level(*source_, found, segment_.end) || found == segment_.end) {
    cluster_end_ = found;
    cluster_is_open_ = false;
  } else if (sound_end > cluster_end_) { // the cluster's own header is lost or wrong
    cluster_time_ = sound_time;
    cluster_end_ = segment_.end;
    cluster_is_open_ = true;
  }
  return found;
}

void Reader::refresh() {
  source_->refresh();
  const Element head = read_element_header(*source_, segment_.start, source_->size());
  segment_.unknown_size = head.unknown_size;
  truncated_ = head.end > source_->size();
  segment_.end = std::min(head.end, source_->size());
}

void Reader::skip_to_last_key(std::uint16_t track) {
  struct {
    std::uint64_t position, cluster_end, cluster_time;
    bool open;
  } last{position_, cluster_end_, cluster_time_, cluster_is_open_};
  StoredBlock block;
  while (next_block(block)) {
    if (!tracks_[block.track].ours || tracks_[block.track].track.id != track || !read_payload(block).key) continue;
    last = {block.offset, cluster_end_, cluster_time_, cluster_is_open_};
  }
  position_ = last.position;
  cluster_end_ = last.cluster_end;
  cluster_time_ = last.cluster_time;
  cluster_is_open_ = last.open;
}

} // namespace kinora::container
