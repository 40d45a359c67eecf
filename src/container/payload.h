// What a Kinora file holds, whoever writes or reads it: tracks of timed payloads, attachments and tags.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kinora::container {

using Bytes = std::vector<std::byte>;

/// What Matroska says of a track that any player understands (video or sound), besides its codec. Zero: not said.
struct MediaFormat {
  int width = 0; ///< of video, pixels
  int height = 0;
  int sampling_rate = 0; ///< of sound, Hz
  int channels = 0;
  int bits = 0;                 ///< of a sample
  std::int64_t duration_ns = 0; ///< nominal, of a frame
  std::int64_t delay_ns = 0;    ///< of sound: decoded at the beginning and not heard (CodecDelay)
};

/// A track of payloads of one kind; or of blocks of a codec that any player understands.
struct Track {
  std::uint16_t id =
      0;              ///< chosen by whoever writes; unique in the file; survives remuxing (Matroska's number does not)
  std::string codec;  ///< Matroska CodecID: "S_KINORA/…", or "V_…", "A_…" with `media`
  std::string name;   ///< for people: what mkvinfo shows
  Bytes private_data; ///< of the codec; may be empty
  std::optional<MediaFormat> media = std::nullopt; ///< its blocks have no envelope: neither checksum nor exact time
};

/// A file inside the file.
struct Attachment {
  std::string name; ///< unique in the file
  std::string media_type;
  std::string description;
  Bytes bytes;
};

/// A moment of the file's time that people find by name; it lasts until the next.
struct Chapter {
  std::int64_t time_ns = 0; ///< from the start of the clip, not negative
  std::string title;
  friend bool operator==(const Chapter&, const Chapter&) = default;
};

/// Tags of the whole file: names in Matroska's manner, upper case with underscores.
using Tags = std::vector<std::pair<std::string, std::string>>;

/// One piece of a track. Its bytes were, or will be, protected by a checksum over track, time, key flag and bytes.
struct Payload {
  std::uint16_t track = 0;  ///< Track::id
  std::int64_t time_ns = 0; ///< from the start of the clip, not negative
  bool key = false;         ///< understood without the track's earlier payloads
  Bytes bytes;
  std::uint64_t offset = 0;       ///< reading: byte of the file where its element starts
  std::uint64_t stored_bytes = 0; ///< reading: what it takes in the file, with all headers
};

/// The tag that says what kind of file it is ("clip") and the one with the version of the layout ("1").
inline constexpr const char* kKindTag = "KINORA_KIND";
inline constexpr const char* kVersionTag = "KINORA_VERSION";
inline constexpr int kFileVersion = 1;

/// Every CodecID of ours begins so.
inline constexpr const char* kCodecPrefix = "S_KINORA/";

} // namespace kinora::container
