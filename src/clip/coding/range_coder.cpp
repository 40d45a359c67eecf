#include "clip/coding/range_coder.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::clip {

bool RangeEncoder::code(BitModel& model, bool bit) {
  left_.narrow(bit, left_.split(model));
  model.learn(bit);
  for (; left_.is_first_byte_settled(); left_.drop_first_byte())
    out_.push_back(static_cast<std::byte>(left_.high >> 24));
  return bit;
}

std::vector<std::byte> RangeEncoder::finish() {
  // The fewest bytes that, followed by zeros, lie between low and high.
  for (int kept = 0; kept <= 4; ++kept) {
    const std::uint32_t mask = kept == 0 ? 0 : ~0U << (32 - 8 * kept);
    const std::uint64_t value = (std::uint64_t{left_.low} + ~mask) & ~std::uint64_t{~mask};
    if (value > left_.high) continue;
    for (int i = 0; i < kept; ++i) out_.push_back(static_cast<std::byte>((value >> (24 - 8 * i)) & 0xFF));
    break;
  }
  return std::move(out_);
}

RangeDecoder::RangeDecoder(std::span<const std::byte> bytes, const std::string& location)
    : bytes_(bytes), location_(location) {
  for (int i = 0; i < 4; ++i) code_ = (code_ << 8) | next_byte();
}

std::uint32_t RangeDecoder::byte_after_end(std::size_t at) const {
  if (at >= bytes_.size() + 4) {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: arithmetic code ends too early", location_));
  }
  return 0;
}

void RangeDecoder::finish() const {
  if (read_ < bytes_.size()) {
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: {} bytes follow the end of an arithmetic code", location_, bytes_.size() - read_));
  }
}

} // namespace kinora::clip
