#include "tracking/brick_surface.h"

#include <algorithm>

#include "core/parallel.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kBricksPerChunk = 16;
constexpr float kSeenOften = 6;      // views
constexpr std::size_t kFewInTen = 1; // points of ten that may have been seen less often

bool is_known(std::span<const SurfacePoint> points, float weight) {
  const auto young =
      std::count_if(points.begin(), points.end(), [&](const SurfacePoint& p) { return p.weight < weight; });
  return weight > 0 && !points.empty() && 10 * static_cast<std::size_t>(young) <= kFewInTen * points.size();
}

} // namespace

void BrickSurface::renew_points(const TsdfVolume& volume, std::span<const std::uint8_t> changed, float unit_weight) {
  pieces_.resize(volume.brick_count());
  parallel_for(pieces_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t b = chunk.begin; b < chunk.end; ++b) {
      if (b < changed.size() && changed[b] == 0) continue;
      Piece& piece = pieces_[b];
      piece.points.clear();
      volume.append_surface(b, 0, piece.points);
      piece.is_known = is_known(piece.points, kSeenOften * unit_weight);
      piece.is_skinned = false;
    }
  });
  points_.clear();
  for (const Piece& piece : pieces_) points_.insert(points_.end(), piece.points.begin(), piece.points.end());
}

void BrickSurface::renew_skin(const BrickInfluences& influences) {
  parallel_for(pieces_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t b = chunk.begin; b < chunk.end; ++b) {
      Piece& piece = pieces_[b];
      const std::uint32_t revision = influences.revision(b);
      if (piece.is_skinned && piece.influences == revision) continue;
      piece.skin.clear();
      for (const SurfacePoint& point : piece.points) {
        piece.skin.push_back(influences.at(b, point.position.cast<double>()));
      }
      piece.is_skinned = true;
      piece.influences = revision;
    }
  });
  skin_.clear();
  for (const Piece& piece : pieces_) skin_.insert(skin_.end(), piece.skin.begin(), piece.skin.end());
}

std::vector<std::uint8_t> BrickSurface::resting(std::size_t frame, std::size_t interval) const {
  std::vector<std::uint8_t> marks;
  for (std::size_t b = 0; b < pieces_.size(); ++b) {
    marks.push_back(pieces_[b].is_known && (b + frame) % interval != 0 ? 1 : 0);
  }
  return marks;
}

} // namespace kinora::tracking
