// Which of a tile's samples must be drawn where a picture of all that stays where it is is at hand.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fields/rendering/rasterizer.h"

namespace kinora::fields {

/// A pixel changes if something that moves comes near one of its samples, or of those that TileSamples::fill() looks at
/// for one of them. Not thread-safe.
class TileChanges {
public:
  static constexpr std::size_t kTile = TriangleBins::kTile;
  /// A bit for each sample, the left one lowest, row by row.
  using Samples = std::array<std::uint16_t, kTile>;
  static_assert(kTile == 16);

  /// `touched`: samples that something that moves comes near; `per_side`² of them make a pixel.
  void find(const Samples& touched, int per_side);
  void set_all() {
    changed_.fill(0xFFFF);
    needed_.fill(0xFFFF);
  }
  /// The pixel of that sample.
  bool changed(std::size_t sample) const { return is_set(changed_, sample); }
  /// Whether that sample is looked at for pixels that change.
  bool needed(std::size_t sample) const { return is_set(needed_, sample); }

private:
  static bool is_set(const Samples& samples, std::size_t sample) {
    return (samples[sample / kTile] >> (sample % kTile) & 1) != 0;
  }

  Samples changed_{}, needed_{};
};

} // namespace kinora::fields
