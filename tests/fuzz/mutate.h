// Damage for fuzz tests: the same random numbers give the same damage.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/random.h"

namespace kinora::fuzz {

/// One to eight changes: flipped bits, bytes of extreme values, runs that are cut out, repeated or overwritten, and a
/// cut end.
inline std::vector<std::byte> mutate(std::vector<std::byte> bytes, Random& random) {
  const auto location = [&] { return random.below(static_cast<std::uint32_t>(bytes.size())); };
  for (std::uint32_t changes = 1 + random.below(8); changes > 0 && !bytes.empty(); --changes) {
    const std::size_t at = location();
    const auto here = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t run = std::min<std::size_t>(1 + random.below(40), bytes.size() - at);
    switch (random.below(7)) {
    case 0:
    case 1:
      *here ^= static_cast<std::byte>(1U << random.below(8));
      break;
    case 2:
      *here = random.below(2) == 0 ? std::byte{0xFF} : std::byte{0};
      break;
    case 3:
      bytes.erase(here, here + static_cast<std::ptrdiff_t>(run));
      break;
    case 4: {
      const std::vector<std::byte> copy(here, here + static_cast<std::ptrdiff_t>(run));
      bytes.insert(bytes.begin() + location(), copy.begin(), copy.end());
      break;
    }
    case 5:
      for (std::size_t i = 0; i < run; ++i) bytes[at + i] = static_cast<std::byte>(random.below(256));
      break;
    default:
      if (random.below(4) == 0) bytes.resize(at);
      break;
    }
  }
  return bytes;
}

} // namespace kinora::fuzz
