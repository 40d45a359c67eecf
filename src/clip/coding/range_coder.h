// An adaptive binary arithmetic coder and integers coded with it. docs/container.md specifies the bits.
// Source: Howard and Vitter, "Practical Implementations of Arithmetic Coding", 1992; the carry-free interval of 32 bits
// as in Mahoney's lpaq; integers as Exp-Golomb codes with adaptive bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kinora::clip {

/// How probable it is that a bit is set, learnt from those that came before: quickly at first, then more slowly.
class BitModel {
public:
  /// In 1/4096, from 1 to 4095.
  std::uint32_t probability() const { return probability_ >> 4; }
  void learn(bool bit) {
    constexpr std::uint32_t kLeast = 16; // so that no bit is ever impossible
    constexpr std::uint32_t kMost = 0xFFFF - 15;
    // Divides by about the number of bits seen: 2, 3, … up to 32.
    const std::uint64_t distance = bit ? kMost - probability_ : probability_ - kLeast;
    const auto change = static_cast<std::uint32_t>((distance * kReciprocals[seen_]) >> kReciprocalShift);
    probability_ = static_cast<std::uint16_t>(bit ? probability_ + change : probability_ - change);
    if (seen_ < kSlowest) ++seen_;
  }

private:
  static constexpr std::size_t kSlowest = 30;
  // Of 2 to 32, rounded up: what is below 2¹⁶ is divided exactly, as container.md demands, but not by a division.
  static constexpr int kReciprocalShift = 21;
  static constexpr std::array<std::uint32_t, kSlowest + 1> kReciprocals = [] {
    std::array<std::uint32_t, kSlowest + 1> reciprocals{};
    for (std::uint32_t seen = 0; seen < reciprocals.size(); ++seen) {
      reciprocals[seen] = ((1U << kReciprocalShift) + seen + 1) / (seen + 2);
    }
    return reciprocals;
  }();

  std::uint16_t probability_ = 1U << 15;
  std::uint8_t seen_ = 0;
};

/// What is left of all codes once the bits so far are known, beyond the bytes that are settled. low ≤ high.
struct CodeInterval {
  std::uint32_t low = 0;
  std::uint32_t high = ~0U;

  /// Where the part of a set bit ends; that of a clear one begins one further. low ≤ split < high.
  std::uint32_t split(const BitModel& model) const {
    return low + static_cast<std::uint32_t>((std::uint64_t{high - low} * model.probability()) >> 12);
  }
  void narrow(bool bit, std::uint32_t middle) {
    if (bit) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  /// Whether all codes have their first byte in common.
  bool is_first_byte_settled() const { return ((low ^ high) & 0xFF000000) == 0; }
  void drop_first_byte() {
    low <<= 8;
    high = (high << 8) | 0xFF;
  }
};

/// Both coders have the same member `code`, so that a syntax is written once, as a template, for both directions.
class RangeEncoder {
public:
  /// Writes `bit` and returns it.
  bool code(BitModel& model, bool bit);
  /// The whole code; the encoder is spent.
  std::vector<std::byte> finish();

private:
  std::vector<std::byte> out_;
  CodeInterval left_;
};

/// Safe for untrusted bytes. `location` must outlive the decoder. Throws Error(kCorruptInput) naming it.
class RangeDecoder {
public:
  RangeDecoder(std::span<const std::byte> bytes, const std::string& location);
  /// The next bit; the argument has no meaning. Throws when the code ends before.
  bool code(BitModel& model, bool /*bit*/ = false) {
    const std::uint32_t middle = left_.split(model);
    const bool bit = code_ <= middle;
    left_.narrow(bit, middle);
    model.learn(bit);
    while (left_.is_first_byte_settled()) {
      left_.drop_first_byte();
      code_ = (code_ << 8) | next_byte();
    }
    return bit;
  }
  /// Throws unless the code ends here.
  void finish() const;

private:
  std::uint32_t next_byte() {
    const std::size_t at = read_++;
    return at < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[at]) : byte_after_end(at);
  }
  // Zeros, as many as may follow the last byte.
  std::uint32_t byte_after_end(std::size_t at) const;

  std::span<const std::byte> bytes_;
  const std::string& location_;
  std::size_t read_ = 0; // bytes taken, counting the zeros that follow the last
  CodeInterval left_;
  std::uint32_t code_ = 0;
};

/// What has been learnt about one kind of integer.
struct IntegerModel {
  static constexpr std::size_t kClasses = 31; // of size: 1, 2–3, 4–7, …
  static constexpr std::size_t kLearntBits = 2;
  BitModel zero;
  BitModel sign;
  std::array<BitModel, kClasses> larger;
  std::array<std::array<BitModel, 1U << kLearntBits>, kClasses> mantissa; // its highest bits; the others cost one bit
};

/// Writes `value`, whose size is below 2³¹, and returns it; or reads and returns one.
template <class Coder> std::int32_t code_integer(Coder& coder, IntegerModel& model, std::int32_t value = 0) {
  const bool negative = value < 0;
  const auto size = static_cast<std::uint32_t>(negative ? -value : value);
  if (coder.code(model.zero, size == 0)) return 0;
  const bool minus = coder.code(model.sign, negative);
  std::size_t bits = 0;
  while (bits + 1 < IntegerModel::kClasses && coder.code(model.larger[bits], (size >> (bits + 1)) != 0)) ++bits;
  std::uint32_t result = 1;
  for (std::size_t b = bits; b-- > 0;) {
    const std::size_t depth = bits - 1 - b;
    const bool wanted = ((size >> b) & 1U) != 0;
    bool bit = false;
    if (depth < IntegerModel::kLearntBits) {
      bit = coder.code(model.mantissa[bits][(std::size_t{1} << depth) - 1 + (depth > 0 ? (result & 1U) : 0)], wanted);
    } else {
      BitModel even; // nothing is learnt about low bits
      bit = coder.code(even, wanted);
    }
    result = (result << 1) | (bit ? 1U : 0U);
  }
  return minus ? -static_cast<std::int32_t>(result) : static_cast<std::int32_t>(result);
}

} // namespace kinora::clip
