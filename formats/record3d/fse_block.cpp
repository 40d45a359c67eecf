// Blocks with finite-state entropy coding (asymmetric numeral systems with tables; Duda, arXiv:1311.2540).
#include <array>
#include <bit>

#include "record3d/lzfse_blocks.h"

namespace kinora::formats {
namespace {

constexpr std::size_t kLengthSymbols = 20; ///< of literals, and of repeats
constexpr std::size_t kDistanceSymbols = 64;
constexpr std::size_t kLiteralSymbols = 256;
constexpr std::uint32_t kLengthStates = 64;
constexpr std::uint32_t kDistanceStates = 256;
constexpr std::uint32_t kLiteralStates = 1024;

/// A symbol stands for the value `base` plus a number of `extra_bits` bits.
struct Value {
  std::uint32_t base;
  std::uint32_t extra_bits;
};
using LengthValues = std::array<Value, kLengthSymbols>;

constexpr LengthValues length_values(std::array<std::uint32_t, 4> extra_bits) {
  LengthValues values{};
  std::uint32_t base = 0;
  for (std::size_t i = 0; i < kLengthSymbols; ++i) {
    values[i] = {base, i < 16 ? 0 : extra_bits[i - 16]};
    base += 1U << values[i].extra_bits;
  }
  return values;
}
constexpr LengthValues kLiteralLengths = length_values({2, 3, 5, 8});
constexpr LengthValues kRepeatLengths = length_values({3, 5, 8, 11});

constexpr std::array<Value, kDistanceSymbols> distance_values() {
  std::array<Value, kDistanceSymbols> values{};
  std::uint32_t base = 0;
  for (std::uint32_t i = 0; i < kDistanceSymbols; ++i) {
    values[i] = {base, i / 4};
    base += 1U << values[i].extra_bits;
  }
  return values;
}
constexpr std::array<Value, kDistanceSymbols> kDistances = distance_values();

/// Bits from the end of a piece towards its beginning: the last byte's highest bits come first.
class BackwardBits {
public:
  /// `unused`: bits at the very end that hold nothing.
  BackwardBits(std::span<const std::byte> bytes, std::uint32_t unused, const ByteReader& reader)
      : bytes_(bytes), reader_(reader), left_(8 * bytes.size()) {
    if (unused > left_) reader.fail("a block is too short");
    left_ -= unused;
  }

  std::uint32_t pull(std::uint32_t count) {
    if (count > left_) reader_.fail("a block is too short");
    left_ -= count;
    std::uint64_t window = 0; // 8 bytes hold 32 bits at any place
    const std::size_t first = left_ / 8;
    for (std::size_t i = 0; i < 8 && first + i < bytes_.size(); ++i)
      window |= std::to_integer<std::uint64_t>(bytes_[first + i]) << (8 * i);
    return static_cast<std::uint32_t>((window >> (left_ % 8)) & ((std::uint64_t{1} << count) - 1));
  }

private:
  std::span<const std::byte> bytes_;
  const ByteReader& reader_;
  std::size_t left_;
};

/// What a state means and where it leads.
struct State {
  std::uint32_t symbol = 0;
  std::uint32_t bits = 0; ///< that are pulled and added to `base`
  std::uint32_t base = 0;
};

/// A decoder's states: each symbol has as many as it is frequent.
template <std::uint32_t count> class StateTable {
public:
  StateTable(std::span<const std::uint16_t> frequencies, const ByteReader& reader) : reader_(reader) {
    std::uint32_t next = 0;
    for (std::uint32_t symbol = 0; symbol < frequencies.size(); ++symbol) {
      const std::uint32_t frequency = frequencies[symbol];
      if (frequency == 0) continue;
      if (frequency > count - next) reader.fail("its tables are absurd");
      const auto bits = static_cast<std::uint32_t>(std::countl_zero(frequency) - std::countl_zero(count));
      const std::uint32_t long_ones = ((2 * count) >> bits) - frequency;
      for (std::uint32_t j = 0; j < frequency; ++j, ++next)
        states_[next] = j < long_ones ? State{symbol, bits, ((frequency + j) << bits) - count}
                                      : State{symbol, bits - 1, (j - long_ones) << (bits - 1)};
    }
    size_ = next;
  }

  /// The symbol of `state`, which becomes the next one.
  std::uint32_t decode(std::uint32_t& state, BackwardBits& bits) const {
    if (state >= size_) reader_.fail("its entropy code is damaged");
    const State& entry = states_[state];
    state = entry.base + bits.pull(entry.bits);
    return entry.symbol;
  }

  /// The same for a symbol with a value, whose extra bits stand behind those of the state.
  std::uint32_t decode(std::uint32_t& state, BackwardBits& bits, std::span<const Value> values) const {
    const Value& value = values[decode(state, bits)];
    return value.base + bits.pull(value.extra_bits);
  }

private:
  const ByteReader& reader_;
  std::array<State, count> states_{};
  std::uint32_t size_ = 0;
};

/// Frequencies in a code of their own: 2 to 14 bits each, from the lowest bit of the first byte on.
class FrequencyReader {
public:
  FrequencyReader(std::span<const std::byte> bytes, const ByteReader& reader) : bytes_(bytes), reader_(reader) {}

  template <std::size_t count> std::array<std::uint16_t, count> read() {
    std::array<std::uint16_t, count> frequencies{};
    if (bytes_.empty()) return frequencies;
    for (std::uint16_t& frequency : frequencies) frequency = next();
    return frequencies;
  }

private:
  std::uint32_t peek() const {
    std::uint32_t window = 0;
    for (std::size_t i = 0; i < 4 && position_ / 8 + i < bytes_.size(); ++i)
      window |= std::to_integer<std::uint32_t>(bytes_[position_ / 8 + i]) << (8 * i);
    return window >> (position_ % 8);
  }

  std::uint16_t next() {
    constexpr std::uint8_t kBits[32] = {2, 3, 2, 5, 2, 3, 2, 8, 2, 3, 2, 5, 2, 3, 2, 14,
                                        2, 3, 2, 5, 2, 3, 2, 8, 2, 3, 2, 5, 2, 3, 2, 14};
    constexpr std::uint8_t kValues[32] = {0, 2, 1, 4, 0, 3, 1, 0, 0, 2, 1, 5, 0, 3, 1, 0,
                                          0, 2, 1, 6, 0, 3, 1, 0, 0, 2, 1, 7, 0, 3, 1, 0};
    const std::uint32_t bits = peek();
    const std::uint32_t length = kBits[bits & 31U];
    position_ += length;
    if (position_ > 8 * bytes_.size()) reader_.fail("its tables are too short");
    if (length == 8) return static_cast<std::uint16_t>(8 + ((bits >> 4U) & 0xfU));
    if (length == 14) return static_cast<std::uint16_t>(24 + ((bits >> 4U) & 0x3ffU));
    return kValues[bits & 31U];
  }

  std::span<const std::byte> bytes_;
  const ByteReader& reader_;
  std::size_t position_ = 0; ///< bits
};

std::uint32_t bits_of(std::uint64_t word, std::uint32_t first, std::uint32_t count) {
  return static_cast<std::uint32_t>((word >> first) & ((std::uint64_t{1} << count) - 1));
}

struct BlockHead {
  std::uint32_t literals, literal_bytes, literal_unused_bits;
  std::array<std::uint32_t, 4> literal_states;
  std::uint32_t matches, match_bytes, match_unused_bits;
  std::uint32_t literal_length_state, repeat_length_state, distance_state;
  std::uint32_t head_bytes; ///< with the magic and the tables
};

BlockHead read_head(ByteReader& reader) {
  (void)reader.number<std::uint32_t>(); // bytes that it unpacks to: the output knows
  const auto a = reader.number<std::uint64_t>();
  const auto b = reader.number<std::uint64_t>();
  const auto c = reader.number<std::uint64_t>();
  BlockHead head{};
  head.literals = bits_of(a, 0, 20);
  head.literal_bytes = bits_of(a, 20, 20);
  head.matches = bits_of(a, 40, 20);
  head.literal_unused_bits = 7 - bits_of(a, 60, 3);
  for (std::uint32_t i = 0; i < 4; ++i) head.literal_states[i] = bits_of(b, 10 * i, 10);
  head.match_bytes = bits_of(b, 40, 20);
  head.match_unused_bits = 7 - bits_of(b, 60, 3);
  head.head_bytes = bits_of(c, 0, 32);
  head.literal_length_state = bits_of(c, 32, 10);
  head.repeat_length_state = bits_of(c, 42, 10);
  head.distance_state = bits_of(c, 52, 10);
  return head;
}

std::vector<std::byte> read_literals(const BlockHead& head, std::span<const std::byte> bytes,
                                     std::span<const std::uint16_t> frequencies, const ByteReader& reader) {
  const StateTable<kLiteralStates> table(frequencies, reader);
  BackwardBits bits(bytes, head.literal_unused_bits, reader);
  std::array<std::uint32_t, 4> states = head.literal_states;
  std::vector<std::byte> literals(head.literals);
  for (std::size_t i = 0; i < literals.size(); ++i)
    literals[i] = static_cast<std::byte>(table.decode(states[i % 4], bits));
  return literals;
}

} // namespace

void unpack_lzfse_block(ByteReader& reader, UnpackedBytes& out) {
  constexpr std::uint32_t kFixedHead = 32; // with the magic
  BlockHead head = read_head(reader);
  if (head.head_bytes < kFixedHead) reader.fail("a block's head is absurd");
  FrequencyReader tables(reader.bytes(head.head_bytes - kFixedHead), reader);
  const StateTable<kLengthStates> literal_lengths(tables.read<kLengthSymbols>(), reader);
  const StateTable<kLengthStates> repeat_lengths(tables.read<kLengthSymbols>(), reader);
  const StateTable<kDistanceStates> distances(tables.read<kDistanceSymbols>(), reader);
  const auto literal_frequencies = tables.read<kLiteralSymbols>();
  const std::vector<std::byte> literals =
      read_literals(head, reader.bytes(head.literal_bytes), literal_frequencies, reader);
  ByteReader next_literals(literals, reader.source());
  BackwardBits bits(reader.bytes(head.match_bytes), head.match_unused_bits, reader);
  std::uint32_t distance = 0;
  for (std::uint32_t i = 0; i < head.matches; ++i) {
    const std::uint32_t count = literal_lengths.decode(head.literal_length_state, bits, kLiteralLengths);
    const std::uint32_t repeated = repeat_lengths.decode(head.repeat_length_state, bits, kRepeatLengths);
    const std::uint32_t given = distances.decode(head.distance_state, bits, kDistances);
    if (given != 0) distance = given;
    out.append(next_literals.bytes(count));
    out.repeat(distance, repeated);
  }
}

} // namespace kinora::formats
