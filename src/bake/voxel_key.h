// A voxel's number as one integer, so that lists of voxels can be sorted and compared.
#pragma once

#include <array>
#include <cstdint>

namespace kinora::bake {

/// 21 bits for each axis: voxels −2²⁰ … 2²⁰ − 1.
using VoxelKey = std::uint64_t;

inline constexpr std::int64_t kVoxelLimit = std::int64_t{1} << 20;

inline VoxelKey voxel_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto bits = [](std::int64_t v) { return static_cast<std::uint64_t>(v + kVoxelLimit); };
  return bits(z) << 42 | bits(y) << 21 | bits(x);
}

inline std::array<std::int32_t, 3> voxel_of(VoxelKey key) {
  constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
  const auto axis = [key](int shift) {
    return static_cast<std::int32_t>(static_cast<std::int64_t>((key >> shift) & kMask) - kVoxelLimit);
  };
  return {axis(0), axis(21), axis(42)};
}

} // namespace kinora::bake
