// Timed payloads out of a Matroska file (RFC 9559) that is not trusted: our own small reader, without libebml.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string_view>

#include "container/byte_source.h"
#include "container/ebml.h"
#include "container/payload.h"

namespace kinora::container {

/// A track of the file: ours, or one that somebody added (video, sound), whose blocks are passed over.
struct StoredTrack {
  Track track;              ///< id and private data only if ours
  std::uint64_t number = 0; ///< Matroska's
  std::uint64_t type = 0;   ///< Matroska's: 1 video, 2 audio, 0x11 subtitle
  bool ours = false;
  Bytes stripped_prefix; ///< header-stripping compression of a remuxer: what stands before every block of this track
};

/// An attachment that has not been read yet.
struct StoredAttachment {
  std::string name;
  std::string media_type;
  std::string description;
  std::optional<std::uint32_t> checksum; ///< CRC-32C of the data, from the description; none if not ours
  Element data;
  std::uint64_t stored_bytes = 0;
};

/// Reads the head at once and payloads one after the other; memory holds one payload. No size from the file is believed
/// before it is checked against the element that holds it and against the file. Not thread-safe.
/// Errors: kNotRecognised (no file, not Matroska), kCorruptInput (damaged; names the file and the byte).
class Reader {
public:
  explicit Reader(const std::filesystem::path& path);
  explicit Reader(std::unique_ptr<ByteSource> source);

  const std::string& name() const { return source_->name(); }
  std::uint64_t file_bytes() const { return source_->size(); }
  const std::vector<StoredTrack>& tracks() const { return tracks_; }
  const std::vector<StoredAttachment>& attachments() const { return attachments_; }
  /// Value of a tag of the whole file.
  std::optional<std::string> tag(std::string_view tag_name) const;
  /// Null if there is none.
  const StoredAttachment* find_attachment(std::string_view attachment_name) const;
  /// Checked against its checksum.
  Bytes read_attachment(const StoredAttachment& attachment);

  /// True if the file ends before its segment does. next() still gives what is whole, then throws at the cut.
  bool truncated() const { return truncated_; }
  /// The next payload of a track of ours, in the file's order; false at the end.
  bool next(Payload& payload);

private:
  void read_ebml_head();
  void find_segment();
  void scan_segment();
  std::uint64_t end_of_open_cluster(const Element& cluster);
  Element element_at(std::uint64_t offset);
  bool enter_cluster();
  bool take_block(const Element& block, const Element& whole, Payload& payload);
  bool take_group(const Element& group, Payload& payload);

  std::unique_ptr<ByteSource> source_;
  Element segment_; // ends with the file if that is shorter
  bool truncated_ = false;
  std::vector<StoredTrack> tracks_;
  std::map<std::uint64_t, std::size_t> track_indices_; // of Matroska's track numbers in tracks_
  std::vector<StoredAttachment> attachments_;
  Tags tags_;
  std::uint64_t position_ = 0;    // of the next element to look at
  std::uint64_t cluster_end_ = 0; // of the cluster that position_ is in; position_ or less between clusters
  bool cluster_is_open_ = false;  // of unknown size: it ends where an element begins that cannot be in a cluster
};

} // namespace kinora::container
