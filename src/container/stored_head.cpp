#include "container/stored_head.h"

#include <algorithm>

#include <fmt/format.h>

#include "container/envelope.h"
#include "container/matroska_ids.h"

namespace kinora::container {

namespace {

constexpr std::uint64_t kHeaderStripping = 3; // ContentCompAlgo, RFC 9559 section 5.1.4.1.31.6

std::string location(const ByteSource& source, const Element& element) {
  return fmt::format("{}: byte {}", source.name(), element.start);
}

// The only encoding that costs nothing to undo; the others are never chosen unless a person asks a remuxer for them.
Bytes parse_stripped_prefix(ByteSource& source, const Element& encodings) {
  Bytes prefix;
  bool understood = true;
  int count = 0;
  for_each_child(source, encodings, [&](const Element& encoding) {
    if (encoding.id != ids::kContentEncoding) return;
    ++count;
    std::uint64_t algorithm = 0;
    for_each_child(source, encoding, [&](const Element& part) {
      if (part.id == ids::kContentEncodingType) understood = understood && read_uint(source, part) == 0;
      if (part.id != ids::kContentCompression) return;
      for_each_child(source, part, [&](const Element& setting) {
        if (setting.id == ids::kContentCompAlgo) algorithm = read_uint(source, setting);
        if (setting.id == ids::kContentCompSettings) prefix = read_bytes(source, setting);
      });
    });
    understood = understood && algorithm == kHeaderStripping;
  });
  if (count > 1 || !understood) {
    throw_corrupt(source, encodings.start,
                  "a Kinora track was compressed or encrypted again; remux with mkvmerge --compression -1:none");
  }
  return prefix;
}

int small_number(double value) { return value >= 0 && value < 1e9 ? static_cast<int>(value) : 0; }

void parse_media(ByteSource& source, const Element& part, MediaFormat& media) {
  for_each_child(source, part, [&](const Element& child) {
    const auto number = [&] { return small_number(static_cast<double>(read_uint(source, child))); };
    if (child.id == ids::kPixelWidth) media.width = number();
    if (child.id == ids::kPixelHeight) media.height = number();
    if (child.id == ids::kSamplingFrequency) media.sampling_rate = small_number(read_float(source, child));
    if (child.id == ids::kChannels) media.channels = number();
    if (child.id == ids::kBitDepth) media.bits = number();
  });
}

StoredTrack parse_track(ByteSource& source, const Element& entry) {
  StoredTrack stored;
  Element codec_private;
  Element encodings;
  MediaFormat media;
  for_each_child(source, entry, [&](const Element& child) {
    switch (child.id) {
    case ids::kTrackNumber:
      stored.number = read_uint(source, child);
      break;
    case ids::kTrackType:
      stored.type = read_uint(source, child);
      break;
    case ids::kTrackName:
      stored.track.name = read_text(source, child);
      break;
    case ids::kCodecId:
      stored.track.codec = read_text(source, child);
      break;
    case ids::kCodecPrivate:
      codec_private = child;
      break;
    case ids::kDefaultDuration:
      media.duration_ns = static_cast<std::int64_t>(read_uint(source, child));
      break;
    case ids::kCodecDelay:
      media.delay_ns = static_cast<std::int64_t>(read_uint(source, child));
      break;
    case ids::kAudio:
      media.sampling_rate = 8000; // what holds where nothing is said: RFC 9559, section 5.1.4.1.29
      media.channels = 1;
      parse_media(source, child, media);
      break;
    case ids::kVideo:
      parse_media(source, child, media);
      break;
    case ids::kContentEncodings:
      encodings = child;
      break;
    default:
      break;
    }
  });
  if (stored.number == 0) throw_corrupt(source, entry.start, "a track without a number");
  stored.ours = stored.track.codec.starts_with(kCodecPrefix);
  if (!stored.ours) {
    if (codec_private.id != 0) stored.track.private_data = read_bytes(source, codec_private);
    stored.track.media = media;
    stored.encoded_again = encodings.id != 0;
    return stored;
  }
  if (codec_private.id == 0) throw_corrupt(source, entry.start, "a Kinora track without private data");
  unwrap_private(read_bytes(source, codec_private), stored.track, location(source, codec_private));
  if (encodings.id != 0) stored.stripped_prefix = parse_stripped_prefix(source, encodings);
  return stored;
}

bool is_of_whole_file(ByteSource& source, const Element& targets) {
  bool whole = true;
  for_each_child(source, targets, [&](const Element& child) {
    if (child.id == ids::kTagTrackUid || child.id == ids::kTagEditionUid || child.id == ids::kTagChapterUid ||
        child.id == ids::kTagAttachmentUid) {
      whole = whole && read_uint(source, child) == 0;
    }
  });
  return whole;
}

void parse_simple_tag(ByteSource& source, const Element& simple, Tags& out) {
  std::string name;
  std::string value;
  for_each_child(source, simple, [&](const Element& child) {
    if (child.id == ids::kTagName) name = read_text(source, child);
    if (child.id == ids::kTagString) value = read_text(source, child);
  });
  if (!name.empty()) out.emplace_back(std::move(name), std::move(value));
}

Chapter parse_chapter(ByteSource& source, const Element& atom) {
  Chapter chapter;
  for_each_child(source, atom, [&](const Element& child) {
    if (child.id == ids::kChapterTimeStart) {
      chapter.time_ns = static_cast<std::int64_t>(std::min<std::uint64_t>(read_uint(source, child), INT64_MAX));
    }
    if (child.id != ids::kChapterDisplay || !chapter.title.empty()) return;
    for_each_child(source, child, [&](const Element& part) {
      if (part.id == ids::kChapString) chapter.title = read_text(source, part);
    });
  });
  return chapter;
}

template <class Read>
void for_each_entry(ByteSource& source, const Element& list, std::uint32_t id, const DamagedEntry& damaged,
                    const Read& read) {
  for_each_child(source, list, [&](const Element& entry) {
    if (entry.id != id) return;
    try {
      read(entry);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCorruptInput) throw;
      damaged(entry, error);
    }
  });
}

} // namespace

void parse_tracks(ByteSource& source, const Element& tracks, const DamagedEntry& damaged,
                  std::vector<StoredTrack>& out) {
  for_each_entry(source, tracks, ids::kTrackEntry, damaged,
                 [&](const Element& entry) { out.push_back(parse_track(source, entry)); });
}

void parse_attachments(ByteSource& source, const Element& attachments, const DamagedEntry& damaged,
                       std::vector<StoredAttachment>& out) {
  for_each_entry(source, attachments, ids::kAttachedFile, damaged, [&](const Element& file) {
    StoredAttachment stored;
    stored.stored_bytes = file.total_size();
    for_each_child(source, file, [&](const Element& child) {
      if (child.id == ids::kFileName) stored.name = read_text(source, child);
      if (child.id == ids::kFileMediaType) stored.media_type = read_text(source, child);
      if (child.id == ids::kFileDescription) stored.description = read_text(source, child);
      if (child.id == ids::kFileData) stored.data = child;
    });
    stored.checksum = take_checksum(stored.description);
    if (!stored.name.empty() && stored.data.id != 0) out.push_back(std::move(stored));
  });
}

void parse_chapters(ByteSource& source, const Element& chapters, std::vector<Chapter>& out) {
  bool found = false;
  for_each_child(source, chapters, [&](const Element& edition) {
    if (edition.id != ids::kEditionEntry || found) return;
    found = true;
    for_each_child(source, edition, [&](const Element& atom) {
      if (atom.id == ids::kChapterAtom) out.push_back(parse_chapter(source, atom));
    });
  });
  std::stable_sort(out.begin(), out.end(), [](const Chapter& a, const Chapter& b) { return a.time_ns < b.time_ns; });
}

void parse_tags(ByteSource& source, const Element& tags, Tags& out) {
  for_each_child(source, tags, [&](const Element& tag) {
    if (tag.id != ids::kTag) return;
    bool whole = true;
    Tags simple_tags;
    for_each_child(source, tag, [&](const Element& child) {
      if (child.id == ids::kTargets) whole = is_of_whole_file(source, child);
      if (child.id == ids::kSimpleTag) parse_simple_tag(source, child, simple_tags);
    });
    if (whole) out.insert(out.end(), simple_tags.begin(), simple_tags.end());
  });
}

} // namespace kinora::container
