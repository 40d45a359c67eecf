#include "fields/rendering/tile_samples.h"

#include <algorithm>

#include "fields/rendering/ray_marching.h"

namespace kinora::fields {

bool TileSamples::fill(std::uint32_t pixel) {
  const std::uint32_t column = pixel % kTile, row = pixel / kTile;
  const bool across = column > 0 && column + 1 < kTile;
  const bool down = row > 0 && row + 1 < kTile;
  if (!across && !down) return false;
  // Where the tile ends, the one opposite stands for the one that is not there.
  const std::array<std::uint32_t, 4> neighbours{
      column > 0 ? pixel - 1 : pixel + 1, column + 1 < kTile ? pixel + 1 : pixel - 1,
      row > 0 ? pixel - kTile : pixel + kTile, row + 1 < kTile ? pixel + kTile : pixel - kTile};
  const Sample& first = samples_[neighbours[0]];
  Eigen::Array4f low = first.color, high = first.color;
  float nearest = first.depth, farthest = first.depth;
  for (const std::uint32_t p : neighbours) {
    const Sample& sample = samples_[p];
    const bool one_layer = sample.front == first.front && sample.max_share == sample.color[3];
    if (!one_layer || !(sample.max_share > 1 - 2 * kOpaque)) return false;
    low = low.min(sample.color);
    high = high.max(sample.color);
    nearest = std::min(nearest, sample.depth);
    farthest = std::max(farthest, sample.depth);
  }
  if (!(high - low <= kColorAgreement).all() || !(farthest - nearest <= kDepthAgreement * nearest)) return false;
  Sample mean;
  const std::size_t begin = across ? 0 : 2, end = down ? 4 : 2; // opposite ones: halfway between them lies the pixel
  const float share = 1 / static_cast<float>(end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    const Sample& sample = samples_[neighbours[i]];
    mean.color += share * sample.color;
    mean.depth += share * sample.depth;
    mean.normal += share * sample.normal;
    mean.confidence += share * sample.confidence;
  }
  if (const float length = mean.normal.norm(); length > 1e-6F) mean.normal /= length;
  mean.max_share = mean.color[3];
  mean.front = first.front;
  samples_[pixel] = mean;
  return true;
}

} // namespace kinora::fields
