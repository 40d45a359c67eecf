#include "record3d/lzfse_blocks.h"

#include <algorithm>

namespace kinora::formats {

void UnpackedBytes::fail() const { throw Error(ErrorCode::kCorruptInput, source_ + ": unpacks to another length"); }

void UnpackedBytes::check_room(std::size_t count) const {
  if (count > bytes_.size() - size_) fail();
}

void UnpackedBytes::append(std::span<const std::byte> bytes) {
  check_room(bytes.size());
  std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += bytes.size();
}

void UnpackedBytes::repeat(std::size_t distance, std::size_t count) {
  if (count == 0) return;
  check_room(count);
  if (distance == 0 || distance > size_) fail();
  for (std::size_t i = 0; i < count; ++i, ++size_) bytes_[size_] = bytes_[size_ - distance]; // may overlap
}

std::vector<std::byte> UnpackedBytes::finish() {
  if (size_ != bytes_.size()) fail();
  return std::move(bytes_);
}

namespace {

/// One instruction: literals that follow it, then bytes from before.
struct Instruction {
  std::size_t literals = 0;
  std::size_t repeated = 0;
  std::size_t distance = 0; ///< 0: as the one before
  bool end = false;
};

Instruction next_instruction(ByteReader& reader) {
  constexpr std::size_t kEndPadding = 7;
  const auto code = reader.number<std::uint8_t>();
  const std::size_t high = code >> 4U;
  const std::size_t low = code & 7U;
  if (high == 0xe) return {(code & 15U) != 0 ? code & 15U : reader.number<std::uint8_t>() + 16U, 0, 0, false};
  if (high == 0xf) return {0, (code & 15U) != 0 ? code & 15U : reader.number<std::uint8_t>() + 16U, 0, false};
  if (high == 0xa || high == 0xb) { // medium distance
    const auto word = reader.number<std::uint16_t>();
    return {(code >> 3U) & 3U, ((low << 2U) | (word & 3U)) + 3, static_cast<std::size_t>(word >> 2U), false};
  }
  if (high == 7 || high == 0xd) reader.fail("holds an instruction that does not exist");
  const std::size_t literals = code >> 6U;
  const std::size_t repeated = ((code >> 3U) & 7U) + 3;
  if (low == 7) return {literals, repeated, reader.number<std::uint16_t>(), false};
  if (low < 6) return {literals, repeated, (low << 8U) | reader.number<std::uint8_t>(), false};
  if (literals != 0) return {literals, repeated, 0, false}; // the distance of the one before
  if (code == 0x06) {
    (void)reader.bytes(kEndPadding);
    return {0, 0, 0, true};
  }
  if (code != 0x0e && code != 0x16) reader.fail("holds an instruction that does not exist");
  return {};
}

} // namespace

void unpack_lzvn_block(ByteReader& outer, UnpackedBytes& out) {
  (void)outer.number<std::uint32_t>(); // bytes that it unpacks to: the output knows
  const auto size = outer.number<std::uint32_t>();
  ByteReader reader(outer.bytes(size), outer.source());
  std::size_t distance = 0;
  for (;;) {
    const Instruction instruction = next_instruction(reader);
    if (instruction.end) return;
    out.append(reader.bytes(instruction.literals));
    if (instruction.distance != 0) distance = instruction.distance;
    out.repeat(distance, instruction.repeated);
  }
}

} // namespace kinora::formats
