// How well the capture's cameras saw each part of a layer, and which side of it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "fields/model/field.h"

namespace kinora::fields {

/// Canonical space in blocks of kBlock³ cells of the occupancy: those that hold an occupied cell, in order of their
/// index. Each has, for kNormals normals that a surface in it may have, a level from 0, no camera ever saw that side,
/// to kMax. n looks along the normal give kMax · n / (n + 1), where one look is one frame that shows as much surface
/// as a block's face: what was seen once, face to face, has one half. From aside it is that times the cosine to the
/// normal, the share of the pixels that are left; of all angles the one counts that gives most. Thread-safe to read.
class Confidence {
public:
  static constexpr int kBlock = 4;
  static constexpr int kMax = 15;
  /// Normals point from the middle of a cube of 3³ places to the others: x, y, z of −1, 0 and 1, x fastest.
  static constexpr std::size_t kNormals = 26;
  using Levels = std::array<std::uint8_t, kNormals>;

  /// Nothing has been seen.
  explicit Confidence(const Occupancy& occupancy);

  const Occupancy& blocks() const { return blocks_; }
  /// Number of the block there, or −1; anywhere outside too.
  int block_at(int x, int y, int z) const;
  std::vector<Levels>& levels() { return levels_; } ///< per block
  const std::vector<Levels>& levels() const { return levels_; }

  /// Unit vector.
  static Eigen::Vector3f normal(std::size_t number);

  /// The up to eight blocks about a position relative to the box, with their trilinear shares, which add up to one, or
  /// to zero if there is none.
  struct Near {
    std::array<std::size_t, 8> blocks{};
    std::array<float, 8> shares{};
  };
  Near near(const std::array<float, 3>& position) const;

  /// 0…1, of the surface at a position relative to the box whose normal, in canonical space, is `normal`. Interpolated
  /// among blocks and normals.
  float at(const std::array<float, 3>& position, const Eigen::Vector3f& normal) const;

private:
  Occupancy blocks_;
  std::vector<std::uint32_t> first_; // number of the first block of each word
  std::vector<Levels> levels_;
};

} // namespace kinora::fields
