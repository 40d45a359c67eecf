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
  Tags tags;                          ///< besides kind and version
  std::int64_t duration_ns = 0;       ///< at least; the last payload's time if that is later
  std::vector<Chapter> chapters = {}; ///< in the order of time
};

/// When a cluster ends, and what has become of it then.
struct WriterOptions {
  std::size_t cluster_bytes = 1 << 20;     ///< of payloads, unless one alone has more
  std::int64_t cluster_ns = 5'000'000'000; ///< from its first payload's time, at most 30 s
  bool durable = false;                    ///< it is on the disk, not only with the system, when write() returns
  bool any_order = false;                  ///< times may decrease, as in what remuxers make
};

/// Writes a file from front to end; memory holds one cluster and the cues (one for each track and cluster). A file that
/// is not finished can be read up to its last whole cluster (Reading::kFollow). The same calls give the same bytes:
/// there is no date inside, and identifiers come from the contents. Not thread-safe. Every method throws
/// Error(kUnwritableOutput) naming the path when the system refuses, and Error(kFailure) when the call itself breaks a
/// rule below. Without finish() the file stays incomplete.
class Writer {
public:
  /// Creates or replaces the file. There is at least one track; codecs begin with "S_KINORA/" unless the track has a
  /// media format; track ids and attachment names are unique.
  Writer(const std::filesystem::path& path, const FileHead& head, const WriterOptions& options = {});
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Times are not negative and never decrease from call to call, over all tracks (unless `any_order`); bytes are fewer
  /// than 2 GB.
  void write(std::uint16_t track, std::int64_t time_ns, bool key, std::span<const std::byte> bytes);
  /// Ends the cluster: what was written so far can be read by whoever follows the file.
  void flush();
  /// Writes cues, sizes, duration and identifiers, and closes the file. Nothing may follow.
  void finish();
  /// After an error of write(), flush() or finish(), such as a full disk: cuts the file behind its last whole cluster
  /// and completes it in the room that it has. Nothing may follow.
  void finish_at_last_cluster();

private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace kinora::container
