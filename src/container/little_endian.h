// Numbers as little-endian bytes, whatever the machine.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace kinora::container {

/// Appends to `out`. Signed integers as two's complement.
template <std::integral T> void put(std::vector<std::byte>& out, T value) {
  const auto bits = static_cast<std::make_unsigned_t<T>>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i) out.push_back(static_cast<std::byte>((bits >> (8 * i)) & 0xFF));
}

/// Appends an IEEE 754 double.
inline void put(std::vector<std::byte>& out, double value) {
  std::uint64_t bits = 0; // not std::bit_cast, which Emscripten's library lacks
  std::memcpy(&bits, &value, sizeof bits);
  put(out, bits);
}

/// Reads at `offset`; the caller has checked that offset + sizeof(T) ≤ bytes.size().
template <std::integral T> T get(std::span<const std::byte> bytes, std::size_t offset) {
  std::make_unsigned_t<T> bits = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bits = static_cast<std::make_unsigned_t<T>>(
        bits | static_cast<std::make_unsigned_t<T>>(std::to_integer<std::uint64_t>(bytes[offset + i]) << (8 * i)));
  }
  return static_cast<T>(bits);
}

inline double get_double(std::span<const std::byte> bytes, std::size_t offset) {
  const auto bits = get<std::uint64_t>(bytes, offset);
  double value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

} // namespace kinora::container
