#include "container/lacing.h"

#include <bit>
#include <optional>

namespace kinora::container {
namespace {

/// Numbers in front of the frames.
class SizeReader {
public:
  explicit SizeReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  std::optional<std::uint8_t> byte() {
    if (rest_.empty()) return std::nullopt;
    const auto value = std::to_integer<std::uint8_t>(rest_.front());
    rest_ = rest_.subspan(1);
    return value;
  }
  /// Bytes of 255, and one below, to be summed up.
  std::optional<std::int64_t> xiph() {
    std::int64_t sum = 0;
    for (;;) {
      const auto value = byte();
      if (!value) return std::nullopt;
      sum += *value;
      if (*value != 255) return sum;
    }
  }
  /// An integer of EBML's variable size; `is_signed`: around the middle of its range.
  std::optional<std::int64_t> variable(bool is_signed) {
    const auto first = byte();
    if (!first || *first == 0) return std::nullopt;
    const int length = std::countl_zero(*first) + 1;
    std::int64_t value = *first & (0xFF >> length);
    for (int i = 1; i < length; ++i) {
      const auto next = byte();
      if (!next) return std::nullopt;
      value = value << 8 | *next;
    }
    return is_signed ? value - ((std::int64_t{1} << (7 * length - 1)) - 1) : value;
  }
  std::span<const std::byte> rest() const { return rest_; }

private:
  std::span<const std::byte> rest_;
};

} // namespace

std::vector<std::span<const std::byte>> laced_frames(std::span<const std::byte> block, Lacing lacing) {
  if (lacing == Lacing::kNone) return {block};
  SizeReader reader(block);
  const auto last = reader.byte(); // number of the last frame
  if (!last) return {};
  const std::size_t count = std::size_t{*last} + 1;
  std::vector<std::int64_t> sizes;
  sizes.reserve(count);
  for (std::size_t i = 0; i + 1 < count; ++i) {
    std::optional<std::int64_t> size;
    if (lacing == Lacing::kFixed) {
      size = static_cast<std::int64_t>(reader.rest().size() / count);
    } else if (lacing == Lacing::kXiph) {
      size = reader.xiph();
    } else {
      size = reader.variable(i > 0);
      if (size && i > 0) *size += sizes.back();
    }
    if (!size || *size < 0 || static_cast<std::uint64_t>(*size) > block.size()) return {};
    sizes.push_back(*size);
  }
  if (lacing == Lacing::kFixed && reader.rest().size() % count != 0) return {};
  std::vector<std::span<const std::byte>> frames;
  frames.reserve(count);
  std::span<const std::byte> rest = reader.rest();
  for (const std::int64_t size : sizes) {
    if (static_cast<std::uint64_t>(size) > rest.size()) return {};
    frames.push_back(rest.first(static_cast<std::size_t>(size)));
    rest = rest.subspan(static_cast<std::size_t>(size));
  }
  frames.push_back(rest);
  return frames;
}

} // namespace kinora::container
