// Bytes of a file that come in any order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "container/cue_index.h"

namespace kinora::player {

/// Not thread-safe.
class HeldBytes {
public:
  using ByteRange = container::ByteRange;

  std::size_t size() const { return bytes_; }
  /// What is there already stays as it is.
  void add(std::uint64_t offset, std::span<const std::byte> bytes);
  /// What is there stays, with other bytes; from `offset` on they must be there in one piece.
  void replace(std::uint64_t offset, std::span<const std::byte> bytes);
  /// The first that are not there, from `offset` on up to the next that are, or to `file_bytes`.
  std::optional<ByteRange> missing(std::uint64_t offset, std::uint64_t file_bytes) const;
  /// Those that follow each other from the file's first on.
  std::span<const std::byte> front() const;
  /// All of them, one piece behind the other. Valid until anything changes.
  std::span<const std::byte> all();
  void clear();

private:
  struct Piece {
    std::uint64_t begin;
    std::vector<std::byte> bytes;

    std::uint64_t end() const { return begin + bytes.size(); }
  };
  void put(std::uint64_t offset, std::span<const std::byte> bytes);

  std::vector<Piece> pieces_; // in order; no two touch
  std::vector<std::byte> joined_;
  std::size_t bytes_ = 0;
};

} // namespace kinora::player
