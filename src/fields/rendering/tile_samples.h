// What a tile's pixels show. As on a chessboard, the pixels of one kind are drawn first; one between them need not be
// drawn where those around it agree.
// Source: Whitted, "An Improved Illumination Model for Shaded Display", CACM 1980 (sampling where corners disagree).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "fields/rendering/rasterizer.h"

namespace kinora::fields {

struct Sample {
  Eigen::Array4f color = Eigen::Array4f::Zero(); ///< sRGB times opacity, then opacity
  float max_share = 0;                           ///< opacity of the layer `front`
  std::uint8_t front = 0;                        ///< 1 + the layer that contributes most; 0: none
  float depth = 0;
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float confidence = 0; ///< times opacity

  /// `share` of the light comes from a layer, in this sRGB (its fourth number means nothing); each layer once.
  void add(std::uint32_t layer, const Eigen::Array4f& rgb, float share) {
    Eigen::Array4f more = share * rgb;
    more[3] = share;
    color += more;
    if (share <= max_share) return;
    max_share = share;
    front = static_cast<std::uint8_t>(layer + 1);
  }
};

/// Not thread-safe.
class TileSamples {
public:
  static constexpr std::uint32_t kTile = TriangleBins::kTile;
  /// Colours (sRGB, 0…1) that differ by no more agree: that is seen only side by side.
  static constexpr float kColorAgreement = 6.0F / 255;
  /// The same of depths, relative to the nearest.
  static constexpr float kDepthAgreement = 0.02F;

  void clear() { samples_.fill({}); }
  Sample& operator[](std::size_t pixel) { return samples_[pixel]; }
  const Sample& operator[](std::size_t pixel) const { return samples_[pixel]; }
  /// Gives a pixel the mean of those above and below it and on either side, as far as they are in the tile, if they
  /// agree and show nothing but one opaque layer; otherwise leaves it alone and returns false.
  bool fill(std::uint32_t pixel);

private:
  std::array<Sample, std::size_t{kTile} * kTile> samples_;
};

} // namespace kinora::fields
