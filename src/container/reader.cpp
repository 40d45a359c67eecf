#include "container/reader.h"

#include <array>
#include <set>

#include <fmt/format.h>

#include "container/crc32c.h"
#include "container/envelope.h"
#include "container/matroska_ids.h"
#include "container/stored_head.h"
#include "core/error.h"

namespace kinora::container {

namespace {

constexpr std::uint64_t kMaxHeaderBytes = 12; // identifier and size
constexpr std::uint64_t kBlockTimeAndFlags = 3;
constexpr std::uint8_t kLacingBits = 0x06;

[[noreturn]] void not_recognised(const ByteSource& source, const std::string& why) {
  throw Error(ErrorCode::kNotRecognised, fmt::format("{} is not a Kinora file: {}", source.name(), why));
}

} // namespace

Reader::Reader(const std::filesystem::path& path) : Reader(std::make_unique<FileSource>(path)) {}

Reader::Reader(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {
  read_ebml_head();
  find_segment();
  scan_segment();
  std::set<std::uint16_t> track_ids;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (!track_indices_.emplace(tracks_[i].number, i).second) {
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
  if (doc_type != "matroska") not_recognised(*source_, "its document type is not matroska");
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
  const bool may_be_cut = truncated_ || segment_.unknown_size;
  Element element;
  try {
    element = read_element_header(*source_, offset, segment_.end);
  } catch (const Error&) {
    if (!may_be_cut || segment_.end - offset >= kMaxHeaderBytes) throw;
    element = {0, offset, segment_.end, segment_.end + 1, false}; // the cut goes through this header
  }
  if (element.end > segment_.end && !may_be_cut) read_element(*source_, offset, segment_.end); // says so
  if (element.end > segment_.end) truncated_ = true;
  if (element.unknown_size && element.id != ids::kCluster) {
    throw_corrupt(*source_, offset, "an element of unknown size where none may be");
  }
  return element;
}

void Reader::scan_segment() {
  bool has_tracks = false;
  for (std::uint64_t at = segment_.body; at < segment_.end;) {
    const Element element = element_at(at);
    if (element.end > segment_.end) break;
    // The same element may stand in a file twice (RFC 9559, section 5.1); the first counts.
    if (element.id == ids::kTracks && !has_tracks) {
      has_tracks = true;
      parse_tracks(*source_, element, tracks_);
    }
    if (element.id == ids::kAttachments && attachments_.empty()) parse_attachments(*source_, element, attachments_);
    if (element.id == ids::kTags && tags_.empty()) parse_tags(*source_, element, tags_);
    at = element.unknown_size ? end_of_open_cluster(element) : element.end;
  }
  if (!has_tracks) throw_corrupt(*source_, segment_.end, "the file ends without a list of tracks");
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
  for (;;) {
    if (position_ >= cluster_end_) {
      if (!enter_cluster()) return false;
      continue;
    }
    if (cluster_is_open_ && ids::ends_cluster(read_element_header(*source_, position_, cluster_end_).id)) {
      cluster_end_ = position_;
      continue;
    }
    const Element element = read_element(*source_, position_, cluster_end_);
    if (element.unknown_size) throw_corrupt(*source_, position_, "an element of unknown size where none may be");
    position_ = element.end;
    if (element.id == ids::kSimpleBlock && take_block(element, element, payload)) return true;
    if (element.id == ids::kBlockGroup && take_group(element, payload)) return true;
  }
}

bool Reader::enter_cluster() {
  while (position_ < segment_.end) {
    const Element element = element_at(position_);
    if (element.id == ids::kCluster) {
      position_ = element.body;
      cluster_end_ = std::min(element.end, segment_.end);
      cluster_is_open_ = element.unknown_size;
      return true;
    }
    if (element.end > segment_.end) break;
    position_ = element.end;
  }
  if (truncated_) throw_corrupt(*source_, segment_.end, "the file is cut short here; fetch it again");
  return false;
}

bool Reader::take_group(const Element& group, Payload& payload) {
  Element block;
  for_each_child(*source_, group, [&](const Element& child) {
    if (child.id == ids::kBlock && block.id == 0) block = child;
  });
  return block.id != 0 && take_block(block, group, payload);
}

bool Reader::take_block(const Element& block, const Element& whole, Payload& payload) {
  const VariableInteger number = read_variable_integer(*source_, block.body, block.end);
  const std::uint64_t rest = block.body_size() - static_cast<std::uint64_t>(number.length);
  const auto index = track_indices_.find(number.value);
  if (index == track_indices_.end()) {
    throw_corrupt(*source_, block.start,
                  fmt::format("a block of track {}, which the file does not list", number.value));
  }
  const StoredTrack& track = tracks_[index->second];
  if (!track.ours) return false;
  if (rest < kBlockTimeAndFlags) throw_corrupt(*source_, block.start, "a block without time and flags");
  const std::uint64_t frame = block.end - rest + kBlockTimeAndFlags;
  std::array<std::byte, 1> flags{};
  source_->read(frame - 1, flags);
  if ((std::to_integer<std::uint8_t>(flags[0]) & kLacingBits) != 0) {
    throw_corrupt(*source_, block.start, "payloads that share a block (lacing); remux with mkvmerge --disable-lacing");
  }
  Bytes bytes = track.stripped_prefix;
  const std::size_t prefix = bytes.size();
  bytes.resize(prefix + static_cast<std::size_t>(block.end - frame));
  source_->read(frame, std::span(bytes).subspan(prefix));
  payload = unwrap_payload(track.track.id, bytes, fmt::format("{}: byte {}", name(), block.start));
  payload.offset = whole.start;
  payload.stored_bytes = whole.total_size();
  return true;
}

} // namespace kinora::container
