// The index of a Matroska file (RFC 9559, section 5.1.5): which of its bytes have what is shown at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "container/byte_source.h"

namespace kinora::container {

/// Bytes of a file, `end` not among them.
struct ByteRange {
  std::uint64_t begin = 0, end = 0;

  bool operator==(const ByteRange&) const = default;
};

/// Immutable, thread-safe.
class CueIndex {
public:
  /// `head`: the file's first bytes, which say where its index is; that is read from `file` at once, of all its bytes
  /// the only ones. Nothing if the head does not say, or if there is no index that helps; safe for untrusted input.
  /// Throws what reading `file` throws.
  static std::optional<CueIndex> read(std::span<const std::byte> head, ByteSource& file);

  /// The clusters with what is shown at that time, from the last key of every track on.
  ByteRange bytes_for(double seconds) const;

private:
  struct Cue {
    double seconds;
    std::uint64_t cluster; // byte of the file
  };
  std::vector<std::vector<Cue>> tracks_; // that can be entered at several times, each in the order of time
  std::uint64_t file_bytes_ = 0;
};

} // namespace kinora::container
