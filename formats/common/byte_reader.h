// Numbers and pieces out of bytes that are not trusted, little-endian.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "core/error.h"

namespace kinora::formats {

/// Reads forwards. Whatever would go beyond the end throws Error(kCorruptInput), naming `source`.
class ByteReader {
public:
  ByteReader(std::span<const std::byte> bytes, std::string source) : bytes_(bytes), source_(std::move(source)) {}

  std::size_t position() const { return position_; }
  std::size_t left() const { return bytes_.size() - position_; }
  const std::string& source() const { return source_; }

  std::span<const std::byte> bytes(std::uint64_t count) {
    if (count > left()) fail("ends too early");
    const auto piece = bytes_.subspan(position_, static_cast<std::size_t>(count));
    position_ += static_cast<std::size_t>(count);
    return piece;
  }

  template <class Number> Number number() {
    Number value;
    std::memcpy(&value, bytes(sizeof value).data(), sizeof value);
    return value;
  }

  std::string text(std::uint64_t count) {
    const auto piece = bytes(count);
    return {reinterpret_cast<const char*>(piece.data()), piece.size()};
  }

  [[noreturn]] void fail(const std::string& problem) const {
    throw Error(ErrorCode::kCorruptInput, source_ + ": " + problem);
  }

private:
  std::span<const std::byte> bytes_;
  std::string source_;
  std::size_t position_ = 0;
};

} // namespace kinora::formats
