// The two kinds of packed blocks of LZFSE.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/byte_reader.h"

namespace kinora::formats {

/// Bytes of which it is known how many there will be.
class UnpackedBytes {
public:
  UnpackedBytes(std::size_t size, std::string source) : bytes_(size), source_(std::move(source)) {}

  /// Both throw Error(kCorruptInput) if it becomes too many, or before the beginning is meant.
  void append(std::span<const std::byte> bytes);
  void repeat(std::size_t distance, std::size_t count);
  /// Throws Error(kCorruptInput) if they are too few.
  std::vector<std::byte> finish();

private:
  void check_room(std::size_t count) const;
  [[noreturn]] void fail() const;

  std::vector<std::byte> bytes_;
  std::string source_;
  std::size_t size_ = 0;
};

/// After the block's magic. Both throw Error(kCorruptInput).
void unpack_lzvn_block(ByteReader& reader, UnpackedBytes& out);
void unpack_lzfse_block(ByteReader& reader, UnpackedBytes& out);

} // namespace kinora::formats
