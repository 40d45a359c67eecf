#include "player/held_bytes.h"

#include <algorithm>

namespace kinora::player {

void HeldBytes::add(std::uint64_t offset, std::span<const std::byte> bytes) {
  const std::uint64_t end = offset + bytes.size();
  for (std::uint64_t at = offset; at < end;) {
    const std::optional<ByteRange> gap = missing(at, end);
    if (!gap) return;
    put(gap->begin,
        bytes.subspan(static_cast<std::size_t>(gap->begin - offset), static_cast<std::size_t>(gap->end - gap->begin)));
    at = gap->end;
  }
}

// Into a gap.
void HeldBytes::put(std::uint64_t offset, std::span<const std::byte> bytes) {
  auto after = std::find_if(pieces_.begin(), pieces_.end(), [&](const Piece& piece) { return piece.begin > offset; });
  auto piece = after;
  if (after != pieces_.begin() && (after - 1)->end() == offset) {
    piece = after - 1;
  } else {
    piece = pieces_.insert(after, Piece{offset, {}});
  }
  piece->bytes.insert(piece->bytes.end(), bytes.begin(), bytes.end());
  bytes_ += bytes.size();
  const auto next = piece + 1;
  if (next == pieces_.end() || next->begin != piece->end()) return;
  piece->bytes.insert(piece->bytes.end(), next->bytes.begin(), next->bytes.end());
  pieces_.erase(next);
}

void HeldBytes::replace(std::uint64_t offset, std::span<const std::byte> bytes) {
  for (Piece& piece : pieces_) {
    if (offset < piece.begin || offset + bytes.size() > piece.end()) continue;
    std::ranges::copy(bytes, piece.bytes.begin() + static_cast<std::ptrdiff_t>(offset - piece.begin));
  }
}

std::optional<HeldBytes::ByteRange> HeldBytes::missing(std::uint64_t offset, std::uint64_t file_bytes) const {
  for (const Piece& piece : pieces_) {
    if (piece.end() <= offset) continue;
    if (piece.begin > offset) {
      return offset < file_bytes ? std::optional(ByteRange{offset, std::min(piece.begin, file_bytes)}) : std::nullopt;
    }
    offset = piece.end();
  }
  return offset < file_bytes ? std::optional(ByteRange{offset, file_bytes}) : std::nullopt;
}

std::span<const std::byte> HeldBytes::front() const {
  if (pieces_.empty() || pieces_.front().begin != 0) return {};
  return pieces_.front().bytes;
}

std::span<const std::byte> HeldBytes::all() {
  joined_.clear();
  if (pieces_.size() == 1) {
    joined_.shrink_to_fit();
    return pieces_.front().bytes;
  }
  joined_.reserve(bytes_);
  for (const Piece& piece : pieces_) joined_.insert(joined_.end(), piece.bytes.begin(), piece.bytes.end());
  return joined_;
}

void HeldBytes::clear() { *this = {}; }

} // namespace kinora::player
