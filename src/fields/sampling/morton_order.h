// Rays in the order of the places that they look at. A step draws one ray from each of many equal parts of such a list:
// rays that are spread over the whole surface, and that lie together in the memory that neighbours touch.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/parallel.h"

namespace kinora::fields {

/// Cells per side of the box in which order is kept; within a cell it is the list's.
inline constexpr std::uint32_t kOrderCells = 64;

/// The lower six bits of a number, each two bits farther from the one before.
constexpr std::uint32_t spread_bits(std::uint32_t bits) {
  bits = (bits | (bits << 8)) & 0x300F;
  bits = (bits | (bits << 4)) & 0x030C3;
  return (bits | (bits << 2)) & 0x9249;
}

/// Morton code (Morton 1966) of a position relative to the box; positions outside count as on its rim.
inline std::uint32_t morton_code(const std::array<float, 3>& position) {
  std::uint32_t code = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const float inside = position[a] > 0 ? std::min(position[a], 1.0F) : 0; // also of what is not a number
    const auto cell = std::min(static_cast<std::uint32_t>(inside * static_cast<float>(kOrderCells)), kOrderCells - 1);
    code |= spread_bits(cell) << a;
  }
  return code;
}

/// Sorts by morton_code(position_of(ray)), keeping the order of equals. `position_of` is called on any thread. Returns
/// where the rays of each place end, by code.
template <class Rays, class PositionOf>
std::vector<std::size_t> sort_by_morton_code(Rays& rays, const PositionOf& position_of) {
  std::vector<std::uint32_t> codes(rays.size());
  parallel_for(rays.size(), 16384, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) codes[i] = morton_code(position_of(rays[i]));
  });
  std::vector<std::size_t> next(kOrderCells * kOrderCells * kOrderCells + 1);
  for (const std::uint32_t code : codes) ++next[code + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  Rays ordered(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) ordered[next[codes[i]]++] = rays[i];
  rays = std::move(ordered);
  next.pop_back();
  return next;
}

} // namespace kinora::fields
