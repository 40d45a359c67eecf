#include "fields/model/confidence.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kinora::fields {
namespace {

constexpr int kMiddle = Confidence::kNormals / 2; // of the cube of 3³ places

/// The cell of a grid that holds a place, and the shares of its eight corners.
struct Cell {
  explicit Cell(const Eigen::Vector3f& at) {
    const Eigen::Vector3f floor = at.array().floor();
    low = floor.cast<int>();
    fraction = at - floor;
  }
  Eigen::Vector3i corner(int number) const { return low + bits(number); }
  float share(int number) const {
    const Eigen::Array3f high = bits(number).cast<float>();
    return (high * fraction.array() + (1 - high) * (1 - fraction.array())).prod();
  }

  Eigen::Vector3i low;
  Eigen::Vector3f fraction;

private:
  static Eigen::Vector3i bits(int number) { return {number & 1, (number >> 1) & 1, number >> 2}; }
};

} // namespace

Confidence::Confidence(const Occupancy& occupancy) : blocks_(coarsened(occupancy, kBlock)) {
  first_.reserve(blocks_.words().size());
  std::uint32_t count = 0;
  for (const std::uint64_t word : blocks_.words()) {
    first_.push_back(count);
    count += static_cast<std::uint32_t>(std::popcount(word));
  }
  levels_.assign(count, Levels{});
}

int Confidence::block_at(int x, int y, int z) const {
  const int side = blocks_.resolution();
  if (x < 0 || y < 0 || z < 0 || x >= side || y >= side || z >= side || !blocks_.at(x, y, z)) return -1;
  const int cell = (z * side + y) * side + x;
  const auto word = static_cast<std::size_t>(cell / 64);
  const std::uint64_t before = blocks_.words()[word] & ((std::uint64_t{1} << (cell % 64)) - 1);
  return static_cast<int>(first_[word]) + std::popcount(before);
}

Eigen::Vector3f Confidence::normal(std::size_t number) {
  const int from_first = static_cast<int>(number);
  const int index = from_first < kMiddle ? from_first : from_first + 1;
  return Eigen::Vector3i(index % 3 - 1, index / 3 % 3 - 1, index / 9 - 1).cast<float>().normalized();
}

Confidence::Near Confidence::near(const std::array<float, 3>& position) const {
  const Eigen::Array3f inside = Eigen::Map<const Eigen::Array3f>(position.data()).max(0).min(1);
  const Cell cell(inside * static_cast<float>(blocks_.resolution()) - 0.5F);
  Near near;
  float sum = 0;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3i corner = cell.corner(c);
    const int block = block_at(corner.x(), corner.y(), corner.z());
    if (block < 0) continue;
    near.blocks[static_cast<std::size_t>(c)] = static_cast<std::size_t>(block);
    near.shares[static_cast<std::size_t>(c)] = cell.share(c);
    sum += cell.share(c);
  }
  if (sum > 0) {
    for (float& share : near.shares) share /= sum;
  }
  return near;
}

float Confidence::at(const std::array<float, 3>& position, const Eigen::Vector3f& normal) const {
  const float longest = normal.cwiseAbs().maxCoeff();
  if (!(longest > 0)) return 0;
  // On the surface of the cube, so that its middle has no share.
  const Cell cell(Eigen::Vector3f(normal / longest).array() + 1);
  const Near blocks_around = near(position);
  float level = 0;
  for (int c = 0; c < 8; ++c) {
    const float share = cell.share(c);
    if (!(share > 0)) continue;
    const Eigen::Vector3i corner = cell.corner(c);
    const int index = (corner.z() * 3 + corner.y()) * 3 + corner.x();
    const auto number = static_cast<std::size_t>(index < kMiddle ? index : index - 1);
    for (std::size_t i = 0; i < 8; ++i) {
      if (blocks_around.shares[i] > 0)
        level += share * blocks_around.shares[i] * static_cast<float>(levels_[blocks_around.blocks[i]][number]);
    }
  }
  return level / static_cast<float>(kMax);
}

} // namespace kinora::fields
