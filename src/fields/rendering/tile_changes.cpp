#include "fields/rendering/tile_changes.h"

namespace kinora::fields {
namespace {

using Samples = TileChanges::Samples;

/// As on a chessboard: the samples of a row that lie between others.
constexpr unsigned between(std::size_t row) { return row % 2 == 0 ? 0xAAAA : 0x5555; }

/// Those beside, above and below the samples of one row.
unsigned beside(const Samples& samples, std::size_t row) {
  unsigned found = samples[row] << 1U | samples[row] >> 1U;
  if (row > 0) found |= samples[row - 1];
  if (row + 1 < samples.size()) found |= samples[row + 1];
  return found & 0xFFFF;
}

Samples whole_pixels(const Samples& samples, std::size_t per_side) {
  Samples whole{};
  const unsigned pixel = (1U << per_side) - 1;
  for (std::size_t top = 0; top < samples.size(); top += per_side) {
    unsigned any = 0, all = 0;
    for (std::size_t row = top; row < top + per_side; ++row) any |= samples[row];
    for (std::size_t left = 0; left < TileChanges::kTile; left += per_side) {
      if ((any >> left & pixel) != 0) all |= pixel << left;
    }
    for (std::size_t row = top; row < top + per_side; ++row) whole[row] = static_cast<std::uint16_t>(all);
  }
  return whole;
}

} // namespace

void TileChanges::find(const Samples& touched, int per_side) {
  Samples changed{};
  for (std::size_t row = 0; row < kTile; ++row) {
    changed[row] = static_cast<std::uint16_t>(touched[row] | (beside(touched, row) & between(row)));
  }
  changed_ = whole_pixels(changed, static_cast<std::size_t>(per_side));
  Samples asking{};
  for (std::size_t row = 0; row < kTile; ++row) {
    asking[row] = static_cast<std::uint16_t>(changed_[row] & between(row));
  }
  for (std::size_t row = 0; row < kTile; ++row) {
    needed_[row] = static_cast<std::uint16_t>(changed_[row] | beside(asking, row));
  }
}

} // namespace kinora::fields
