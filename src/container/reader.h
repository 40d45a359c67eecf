// Timed payloads out of a Matroska file (RFC 9559) that is not trusted: our own small reader, without libebml.
#pragma once

#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string_view>

#include "container/byte_source.h"
#include "container/damage.h"
#include "container/ebml.h"
#include "container/lacing.h"
#include "container/payload.h"

namespace kinora::container {

/// What a reader does where bytes are wrong or missing.
enum class Reading {
  kStrict,  ///< damage and cuts are errors
  kSalvage, ///< passes over them up to the next cluster or sound payload, and says so in damage()
  kFollow   ///< a file that is being written: next() is false where it ends so far, and goes on after refresh()
};

/// A track of the file: ours, or one of a codec that others know (video, sound).
struct StoredTrack {
  Track track;              ///< id only if ours, media format only if not
  std::uint64_t number = 0; ///< Matroska's
  std::uint64_t type = 0;   ///< Matroska's: 1 video, 2 audio, 0x11 subtitle
  bool ours = false;
  bool encoded_again = false; ///< not ours, and its blocks were compressed once more: they are not what the codec wants
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

/// A block of any track, not read yet.
struct StoredBlock {
  std::size_t track = 0;          ///< place in Reader::tracks()
  std::int64_t time_ns = 0;       ///< Matroska's, rounded; of a payload of ours the exact one stands in its envelope
  std::uint64_t data = 0;         ///< byte of the file where the block's own bytes start, behind its header
  std::uint64_t data_bytes = 0;   ///< without a stripped prefix
  std::uint64_t offset = 0;       ///< byte of the file where its element starts
  std::uint64_t stored_bytes = 0; ///< what it takes in the file, with all headers
  bool key = false;               ///< as Matroska says; of a payload of ours its envelope does
  Lacing lacing = Lacing::kNone;  ///< of a payload of ours: none
};

/// Reads the head at once and payloads one after the other; memory holds one payload. No size from the file is believed
/// before it is checked against the element that holds it and against the file. Not thread-safe.
/// Errors: kNotRecognised (no file, not Matroska), kCorruptInput (damaged; names the file and the byte).
class Reader {
public:
  explicit Reader(const std::filesystem::path& path, Reading reading = Reading::kStrict);
  explicit Reader(std::unique_ptr<ByteSource> source, Reading reading = Reading::kStrict);

  const std::string& name() const { return source_->name(); }
  std::uint64_t file_bytes() const { return source_->size(); }
  const std::vector<StoredTrack>& tracks() const { return tracks_; }
  const std::vector<StoredAttachment>& attachments() const { return attachments_; }
  /// In the order of time.
  const std::vector<Chapter>& chapters() const { return chapters_; }
  /// All tags of the whole file.
  const Tags& tags() const { return tags_; }
  /// Value of a tag of the whole file.
  std::optional<std::string> tag(std::string_view tag_name) const;
  /// Null if there is none.
  const StoredAttachment* find_attachment(std::string_view attachment_name) const;
  /// Checked against its checksum.
  Bytes read_attachment(const StoredAttachment& attachment);

  /// A payload of ours that takes more is damage, before anything is allocated for it. Without: as the file has them.
  void limit_payloads(std::uint64_t bytes) { max_payload_bytes_ = bytes; }

  /// True if the file ends before its segment does. next() still gives what is whole, then throws at the cut (kStrict).
  bool truncated() const { return truncated_; }
  /// True if the file's writer has finished it, as far as its segment says.
  bool finished() const { return !segment_.unknown_size && !truncated_; }
  /// The next payload of a track of ours, in the file's order; false at the end.
  bool next(Payload& payload);

  /// The same for blocks of all tracks, whose bytes are not given. Goes on where next() is, and the other way round.
  /// Payloads of ours are checked with kSalvage alone.
  bool next_block(StoredBlock& block);
  /// The bytes of a block that next_block() gave, with its stripped prefix. There is no check of what they are.
  Bytes read_block(const StoredBlock& block);
  /// The frames that share it, each with its stripped prefix; of a block without lacing it is all one. Empty if their
  /// sizes do not fit the block.
  std::vector<Bytes> read_frames(const StoredBlock& block);
  /// The same of one of our tracks, checked.
  Payload read_payload(const StoredBlock& block);

  /// kSalvage: what was passed over so far: of the head first, then in the file's order. Complete when next() has
  /// returned false.
  const DamageList& damage() const { return damage_; }

  /// kFollow: takes note of what has been written since. Throws Error(kCorruptInput) if the file was made shorter.
  void refresh();
  /// Goes on with the last payload of a track that has the key flag, or stays if none follows: where a late viewer of a
  /// file that is being written starts.
  void skip_to_last_key(std::uint16_t track);

private:
  void read_ebml_head();
  void find_segment();
  void scan_segment();
  void scan_element(const Element& element);
  void check_tracks();
  std::uint64_t end_of_open_cluster(const Element& cluster);
  Element element_at(std::uint64_t offset);
  bool is_incomplete(std::uint64_t offset);
  bool step(StoredBlock& block, bool& found);
  bool enter_cluster();
  bool at_end();
  void take_block(const Element& block, const Element& whole, StoredBlock& out);
  bool take_group(const Element& group, StoredBlock& out);
  void check_plausible(const Element& element, std::uint64_t limit);
  std::uint64_t position_after_failure(std::uint64_t start, std::uint64_t end);

  std::unique_ptr<ByteSource> source_;
  Reading reading_;
  Element segment_; // ends with the file if that is shorter
  bool truncated_ = false;
  std::uint64_t max_payload_bytes_ = std::numeric_limits<std::uint64_t>::max();
  std::vector<StoredTrack> tracks_;
  std::map<std::uint64_t, std::size_t> track_indices_; // of Matroska's track numbers in tracks_
  std::vector<StoredAttachment> attachments_;
  std::vector<Chapter> chapters_;
  Tags tags_;
  std::uint64_t timestamp_scale_ = 1'000'000;
  std::uint64_t position_ = 0;     // of the next element to look at
  std::uint64_t cluster_end_ = 0;  // of the cluster that position_ is in; position_ or less between clusters
  bool cluster_is_open_ = false;   // of unknown size: it ends where an element begins that cannot be in a cluster
  std::uint64_t cluster_time_ = 0; // ticks
  DamageList damage_;
  std::uint64_t last_failure_ = std::numeric_limits<std::uint64_t>::max(); // where damage was met last
  std::uint64_t resync_effort_ = 0; // bytes whose checksums were computed in vain while looking for a sound payload
};

} // namespace kinora::container
