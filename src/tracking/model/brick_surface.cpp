#include "tracking/model/brick_surface.h"

#include <algorithm>

#include "core/parallel.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kBricksPerChunk = 16;
constexpr float kMinViews = 6;       // views
constexpr std::size_t kFewInTen = 1; // points of ten that may have been seen less often

bool is_known(std::span<const SurfacePoint> points, float weight) {
  const auto young =
      std::count_if(points.begin(), points.end(), [&](const SurfacePoint& p) { return p.weight < weight; });
  return weight > 0 && !points.empty() && 10 * static_cast<std::size_t>(young) <= kFewInTen * points.size();
}

} // namespace

void BrickSurface::update_points(const TsdfVolume& volume, std::span<const std::uint8_t> changed, float unit_weight) {
  pieces_.resize(volume.brick_count());
  parallel_for(pieces_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t b = chunk.begin; b < chunk.end; ++b) {
      if (b < changed.size() && changed[b] == 0) continue;
      Piece& piece = pieces_[b];
      piece.points.clear();
      volume.append_surface(b, 0, piece.points);
      piece.is_known = is_known(piece.points, kMinViews * unit_weight);
      piece.is_skinned = false;
    }
  });
  points_.clear();
  for (const Piece& piece : pieces_) points_.insert(points_.end(), piece.points.begin(), piece.points.end());
}

void BrickSurface::update_skinning(const BrickInfluences& influences) {
  parallel_for(pieces_.size(), kBricksPerChunk, [&](const Chunk& chunk) {
    for (std::size_t b = chunk.begin; b < chunk.end; ++b) {
      Piece& piece = pieces_[b];
      const std::uint32_t revision = influences.revision(b);
      if (piece.is_skinned && piece.influences == revision) continue;
      piece.skin.clear();
      motion::PointLanes points{};
      motion::InfluenceLanes lanes;
      for (std::size_t first = 0; first < piece.points.size(); first += motion::PointLanes::kPoints) {
        const std::size_t count = std::min(motion::PointLanes::kPoints, piece.points.size() - first);
        for (std::size_t i = 0; i < count; ++i) points.set(i, piece.points[first + i].position);
        influences.skinning_weights_of(b, points, lanes);
        for (std::size_t i = 0; i < count; ++i) piece.skin.push_back(lanes.at(i));
      }
      piece.is_skinned = true;
      piece.influences = revision;
    }
  });
  skin_.clear();
  for (const Piece& piece : pieces_) skin_.insert(skin_.end(), piece.skin.begin(), piece.skin.end());
}

std::vector<std::uint8_t> BrickSurface::unsupported_bricks(std::span<const Eigen::Vector3d> nodes, double reach,
                                                           float min_weight,
                                                           std::span<const std::uint8_t> changed) const {
  std::vector<std::uint8_t> marks(pieces_.size(), 0);
  for (std::size_t b = 0; b < pieces_.size(); ++b) {
    if (b < changed.size() && changed[b] == 0) continue;
    const Piece& piece = pieces_[b];
    for (std::size_t i = 0; i < piece.points.size() && marks[b] == 0; ++i) {
      if (piece.points[i].weight < min_weight) continue;
      const bool is_near =
          piece.is_skinned && piece.skin[i].count > 0 &&
          (nodes[static_cast<std::size_t>(piece.skin[i].nodes[0])] - piece.points[i].position.cast<double>())
                  .squaredNorm() <= reach * reach;
      if (!is_near) marks[b] = 1;
    }
  }
  return marks;
}

std::vector<std::uint8_t> BrickSurface::skipped(std::size_t frame, std::size_t interval) const {
  std::vector<std::uint8_t> marks;
  for (std::size_t b = 0; b < pieces_.size(); ++b) {
    marks.push_back(pieces_[b].is_known && (b + frame) % interval != 0 ? 1 : 0);
  }
  return marks;
}

} // namespace kinora::tracking
