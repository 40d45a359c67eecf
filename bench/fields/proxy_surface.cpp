#include "fields/proxy_surface.h"

#include <algorithm>
#include <array>

namespace kinora::bench {
namespace {

constexpr int kTile = fields::TriangleBins::kTile;
constexpr float kShell =
    16; // lattice steps: farther behind an entry its hull's surface is not (fields/tile_marcher.cpp)

} // namespace

ProxySurface::ProxySurface(const fields::DrawableField& field, bool corrected)
    : field_(&field), corrected_(corrected) {}

void ProxySurface::prepare(const Instant& instant) {
  camera_ = instant.camera;
  posed_ = fields::pose(*field_, instant.warp);
  view_.emplace(posed_, camera_);
  bins_.emplace(camera_.intrinsics, std::array{fields::TriangleBins::Mesh{view_->corners(), view_->faces()}});
  const int width = camera_.intrinsics.width;
  const int height = camera_.intrinsics.height;
  entries_.clear();
  begin_.assign(1, 0);
  std::vector<fields::Entries> row_of_tiles(static_cast<std::size_t>(bins_->columns()));
  for (int top = 0; top < height; top += kTile) {
    for (int left = 0; left < width; left += kTile) {
      fields::Entries& entries = row_of_tiles[static_cast<std::size_t>(left / kTile)];
      entries.clear();
      const fields::TileRays rays = fields::tile_rays(camera_.intrinsics, left, top);
      for (const std::uint32_t index : bins_->of_tile(left / kTile, top / kTile)) {
        fields::rasterize(bins_->triangle(index), index, rays, entries);
      }
    }
    for (int v = 0; v < std::min(kTile, height - top); ++v) {
      for (int u = 0; u < width; ++u) {
        const fields::Entries& entries = row_of_tiles[static_cast<std::size_t>(u / kTile)];
        const int pixel_of_tile = v * kTile + u % kTile;
        const auto pixel = static_cast<std::size_t>(pixel_of_tile);
        for (std::size_t k = 0; k < entries.count(pixel); ++k) entries_.push_back(entries.at(pixel, k));
        begin_.push_back(static_cast<std::uint32_t>(entries_.size()));
      }
    }
  }
}

void ProxySurface::find(const std::vector<SearchRay>& rays, Positions& positions) {
  const auto n = rays.size() * kSamples;
  points_.resize(n);
  positions_.resize(n);
  std::vector<bool> found(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const SearchRay& ray = rays[i];
    const int number = ray.v * camera_.intrinsics.width + ray.u;
    const auto pixel = static_cast<std::size_t>(number);
    const Eigen::Vector3f view_vector = camera_.intrinsics.unproject(ray.u, ray.v, 1.0).cast<float>();
    const auto surface = static_cast<float>(ray.depth);
    // The last entry before the surface.
    const fields::Entry* entry = nullptr;
    for (std::uint32_t k = begin_[pixel]; k < begin_[pixel + 1] && entries_[k].depth <= surface; ++k) {
      entry = &entries_[k];
    }
    found[i] = entry != nullptr && surface - entry->depth < kShell * view_->lattice_step();
    fields::ProjectedLayer::EntryPoint entry_point{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero(),
                                                   fields::kNoRotation};
    if (found[i]) entry_point = view_->entry_point(*entry, *bins_, view_vector);
    for (std::size_t s = 0; s < kSamples; ++s) {
      const float depth = surface + static_cast<float>(ray.behind[s]);
      points_.set(kSamples * i + s, depth * view_vector);
      const Eigen::Vector3f at =
          found[i] ? entry_point.at + (depth / entry->depth - 1) * entry_point.view_vector : entry_point.at;
      positions_.set(kSamples * i + s, at);
    }
  }
  if (corrected_) view_->refine(n, points_, positions_);
  const fields::ProxyMesh& proxy_mesh = field_->derived().proxy_mesh;
  for (std::size_t k = 0; k < n; ++k) {
    positions.push_back(found[k / kSamples] ? std::optional(proxy_mesh.to_canonical(positions_.at(k))) : std::nullopt);
  }
}

} // namespace kinora::bench
