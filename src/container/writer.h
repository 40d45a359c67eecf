// Timed payloads into a Matroska file (RFC 9559), by libebml and libmatroska.
#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "container/payload.h"

namespace kinora::container {

/// What a file starts with: known before the first payload.
struct FileHead {
  std::string kind; ///< of file: "clip"
  std::vector<Track> tracks;
  std::vector<Attachment> attachments;
  Tags tags;                    ///< besides kind and version
  std::int64_t duration_ns = 0; ///< at least; the last payload's time if that is later
};

/// Writes a file from front to end; memory holds one cluster (about a megabyte, or one payload) and the cues (one for
/// each track and cluster). The same calls give the same bytes: there is no date inside, and identifiers come from the
/// contents. Not thread-safe. Every method throws Error(kUnwritableOutput) naming the path when the system refuses, and
/// Error(kFailure) when the call itself breaks a rule below. Without finish() the file stays incomplete.
class Writer {
public:
  /// Creates or replaces the file. There is at least one track; codecs begin with "S_KINORA/"; track ids and
  /// attachment names are unique.
  Writer(const std::filesystem::path& path, const FileHead& head);
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Times are not negative and never decrease from call to call, over all tracks; bytes are fewer than 2 GB.
  void write(std::uint16_t track, std::int64_t time_ns, bool key, std::span<const std::byte> bytes);
  /// Writes cues, sizes, duration and identifiers, and closes the file. Nothing may follow.
  void finish();

private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace kinora::container
