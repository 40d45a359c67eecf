#include "fields/live_table.h"

#include <bit>
#include <cmath>

#include <Eigen/Geometry>

namespace kinora::bench {
namespace {

constexpr int kPerCell = 4; // voxels along an occupied cell

} // namespace

LiveTable::LiveTable(const fields::FieldConfig& config, const fields::Occupancy& occupancy)
    : config_(&config), occupancy_(&occupancy),
      voxels_per_metre_(static_cast<float>(occupancy.resolution() * kPerCell / config.box.side)) {}

LiveTable::Voxel LiveTable::voxel_of(const std::array<float, 3>& live) const {
  Voxel voxel{};
  for (std::size_t a = 0; a < 3; ++a) voxel[a] = static_cast<std::int16_t>(std::floor(live[a] * voxels_per_metre_));
  return voxel;
}

std::size_t LiveTable::slot_of(const Voxel& voxel) const {
  // Teschner et al., "Optimized Spatial Hashing for Collision Detection of Deformable Objects", VMV 2003.
  const auto hash = static_cast<std::uint32_t>(voxel[0]) * 73856093U ^
                    static_cast<std::uint32_t>(voxel[1]) * 19349663U ^ static_cast<std::uint32_t>(voxel[2]) * 83492791U;
  std::size_t slot = hash & (slots_.size() - 1);
  while (slots_[slot].number >= 0 && slots_[slot].voxel != voxel) slot = (slot + 1) & (slots_.size() - 1);
  return slot;
}

void LiveTable::prepare(const Instant& instant) {
  const motion::BulkWarp bulk(instant.table, instant.warp);
  canonical_origin_ = bulk.canonical_origin();
  world_origin_ = bulk.world_origin();
  if (canonical_.empty()) { // the same in all frames
    const int n = occupancy_->resolution();
    for (int cell = 0; cell < n * n * n; ++cell) {
      const Eigen::Array3i at(cell % n, cell / n % n, cell / (n * n));
      if (!occupancy_->at(at.x(), at.y(), at.z())) continue;
      for (int k = 0; k < kPerCell * kPerCell * kPerCell; ++k) {
        const Eigen::Array3i within(k % kPerCell, k / kPerCell % kPerCell, k / (kPerCell * kPerCell));
        const Eigen::Vector3d middle = (kPerCell * at + within).cast<double>() + 0.5;
        const Eigen::Vector3f p =
            (config_->box.origin - canonical_origin_ + middle / static_cast<double>(voxels_per_metre_)).cast<float>();
        canonical_.push_back({p.x(), p.y(), p.z()});
      }
    }
    warped_.resize(canonical_.size());
  }
  bulk.to_world(canonical_, warped_.data());
  slots_.assign(2 * std::bit_ceil(canonical_.size()), {{}, -1});
  for (std::size_t i = 0; i < warped_.size(); ++i) {
    const std::array<float, 3>& live = warped_[i].point;
    if (!std::isfinite(live[0])) continue; // no node moves it
    const Voxel voxel = voxel_of(live);
    slots_[slot_of(voxel)] = {voxel, static_cast<std::int32_t>(i)};
  }
}

void LiveTable::find(const std::vector<SearchRay>& rays, Positions& positions) {
  for (const SearchRay& ray : rays) {
    for (const double t : ray.behind) {
      const Eigen::Vector3f point = (ray.at(t) - world_origin_).cast<float>();
      const std::int32_t number = slots_[slot_of(voxel_of({point.x(), point.y(), point.z()}))].number;
      if (number < 0) {
        positions.emplace_back();
        continue;
      }
      const auto voxel = static_cast<std::size_t>(number);
      const auto& there = warped_[voxel];
      const Eigen::Vector3f back =
          Eigen::Quaternionf(there.rotation.data()).conjugate() * (point - Eigen::Vector3f(there.point.data()));
      positions.emplace_back((Eigen::Vector3f(canonical_[voxel].data()) + back).cast<double>() + canonical_origin_);
    }
  }
}

} // namespace kinora::bench
