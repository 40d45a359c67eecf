#include "container/resync.h"

#include <algorithm>
#include <array>
#include <vector>

#include "container/matroska_ids.h"
#include "core/error.h"

namespace kinora::container {

namespace {

constexpr std::uint64_t kPieceBytes = 1 << 16;
constexpr std::uint64_t kMaxHeaderBytes = 12;

/// The header at `offset`, if there is one.
std::optional<Element> header_at(ByteSource& source, std::uint64_t offset, std::uint64_t limit) {
  try {
    return read_element_header(source, offset, limit);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Four bytes as an identifier; 0 where there are fewer.
std::uint32_t identifier_at(ByteSource& source, std::uint64_t offset, std::uint64_t limit) {
  std::array<std::byte, 4> bytes{};
  if (limit - offset < bytes.size()) return 0;
  source.read(offset, bytes);
  std::uint32_t id = 0;
  for (const std::byte b : bytes) id = id << 8 | std::to_integer<std::uint32_t>(b);
  return id;
}

/// An element that may stand in a segment or a cluster, as far as identifier and size tell.
bool is_known(const Element& element) {
  const std::uint64_t size = element.body_size();
  switch (element.id) {
  case ids::kTimestamp:
  case ids::kPosition:
  case ids::kPrevSize:
    return size <= 8;
  case ids::kCrc32:
    return size == 4;
  case ids::kVoid:
    return true;
  default:
    return ids::ends_cluster(element.id) || ids::is_block(element.id);
  }
}

/// What a cluster may begin with.
bool begins_cluster(ByteSource& source, const Element& cluster, std::uint64_t limit) {
  const std::uint64_t end = std::min(cluster.end, limit);
  if (cluster.body >= end) return cluster.body == cluster.end;
  const std::optional<Element> child = header_at(source, cluster.body, end);
  return child && child->end <= end && is_known(*child) && !ids::ends_cluster(child->id);
}

} // namespace

bool is_plausible_element(ByteSource& source, std::uint64_t offset, std::uint64_t limit) {
  // Identifiers have one byte: three in a row that fit are no accident.
  constexpr int kChain = 3;
  for (int i = 0; i < kChain && offset < limit; ++i) {
    const std::optional<Element> element = header_at(source, offset, limit);
    if (!element) return i > 0 && limit - offset < kMaxHeaderBytes; // a cut may go through the next one
    if (!is_known(*element)) {                                      // of a later Matroska, if what follows is known
      const std::optional<Element> after = header_at(source, std::min(element->end, limit), limit);
      return i > 0 && (element->end == limit || (after && is_known(*after)));
    }
    if (element->end > limit) return i > 0;
    if (element->unknown_size) return true;
    offset = element->end;
  }
  return true;
}

bool is_plausible_top_level(ByteSource& source, std::uint64_t offset, std::uint64_t limit) {
  const std::optional<Element> element = header_at(source, offset, limit);
  if (!element || !ids::ends_cluster(element->id) || element->id == ids::kEbml || element->id == ids::kSegment) {
    return false;
  }
  if (element->id == ids::kCluster) return begins_cluster(source, *element, limit);
  return !element->unknown_size && element->end <= limit;
}

std::uint64_t find_sync(ByteSource& source, std::uint64_t from, std::uint64_t limit,
                        const std::function<bool(const Element&)>& is_sound) {
  std::vector<std::byte> piece;
  for (std::uint64_t start = from; start < limit; start += kPieceBytes) {
    piece.resize(static_cast<std::size_t>(std::min(kPieceBytes, limit - start)));
    source.read(start, piece);
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const auto first = std::to_integer<std::uint32_t>(piece[i]);
      const std::uint64_t offset = start + i;
      if (first == ids::kSimpleBlock || first == ids::kBlock) {
        const std::optional<Element> block = header_at(source, offset, limit);
        if (block && !block->unknown_size && block->end <= limit && is_sound(*block)) return offset;
      } else if (first >> 4 == 1 && ids::ends_cluster(identifier_at(source, offset, limit)) &&
                 is_plausible_top_level(source, offset, limit)) {
        return offset;
      }
    }
  }
  return limit;
}

} // namespace kinora::container
