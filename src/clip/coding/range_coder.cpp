#include "clip/coding/range_coder.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::clip {

namespace {

constexpr std::uint32_t kTopByte = 0xFF000000;

// Where the interval of a set bit ends and that of a clear one begins (one further). low ≤ split < high.
std::uint32_t split(std::uint32_t low, std::uint32_t high, const BitModel& model) {
  return low + static_cast<std::uint32_t>((std::uint64_t{high - low} * model.probability()) >> 12);
}

} // namespace

void BitModel::learn(bool bit) {
  // Divides by about the number of bits seen: 2, 3, … up to 32.
  constexpr std::uint8_t kSlowest = 30;
  const int rate = seen_ + 2;
  const int target = bit ? 0xFFFF - 15 : 16; // so that no bit is ever impossible
  probability_ = static_cast<std::uint16_t>(probability_ + (target - probability_) / rate);
  if (seen_ < kSlowest) ++seen_;
}

bool RangeEncoder::code(BitModel& model, bool bit) {
  const std::uint32_t middle = split(low_, high_, model);
  if (bit) {
    high_ = middle;
  } else {
    low_ = middle + 1;
  }
  model.learn(bit);
  while (((low_ ^ high_) & kTopByte) == 0) {
    out_.push_back(static_cast<std::byte>(high_ >> 24));
    low_ <<= 8;
    high_ = (high_ << 8) | 0xFF;
  }
  return bit;
}

std::vector<std::byte> RangeEncoder::finish() {
  // The fewest bytes that, followed by zeros, lie between low and high.
  for (int kept = 0; kept <= 4; ++kept) {
    const std::uint32_t mask = kept == 0 ? 0 : ~0U << (32 - 8 * kept);
    const std::uint64_t value = (std::uint64_t{low_} + ~mask) & ~std::uint64_t{~mask};
    if (value > high_) continue;
    for (int i = 0; i < kept; ++i) out_.push_back(static_cast<std::byte>((value >> (24 - 8 * i)) & 0xFF));
    break;
  }
  return std::move(out_);
}

RangeDecoder::RangeDecoder(std::span<const std::byte> bytes, const std::string& location)
    : bytes_(bytes), location_(location) {
  for (int i = 0; i < 4; ++i) code_ = (code_ << 8) | next_byte();
}

std::uint32_t RangeDecoder::next_byte() {
  const std::size_t at = read_++;
  if (at < bytes_.size()) return std::to_integer<std::uint32_t>(bytes_[at]);
  if (at >= bytes_.size() + 4) {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: arithmetic code ends too early", location_));
  }
  return 0;
}

bool RangeDecoder::code(BitModel& model, bool /*bit*/) {
  const std::uint32_t middle = split(low_, high_, model);
  const bool bit = code_ <= middle;
  if (bit) {
    high_ = middle;
  } else {
    low_ = middle + 1;
  }
  model.learn(bit);
  while (((low_ ^ high_) & kTopByte) == 0) {
    low_ <<= 8;
    high_ = (high_ << 8) | 0xFF;
    code_ = (code_ << 8) | next_byte();
  }
  return bit;
}

void RangeDecoder::finish() const {
  if (read_ < bytes_.size()) {
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: {} bytes follow the end of an arithmetic code", location_, bytes_.size() - read_));
  }
}

} // namespace kinora::clip
