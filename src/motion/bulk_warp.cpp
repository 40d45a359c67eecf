#include "motion/bulk_warp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace kinora::motion {

BulkWarp::BulkWarp(std::shared_ptr<const InfluenceTable> table, const Warp& warp)
    : table_(std::move(table)), warp_(warp) {
  if (table_ == nullptr || warp.graph() != &table_->graph()) {
    throw Error(ErrorCode::kFailure, "a table of influences serves the graph that it was made for");
  }
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& node : warp_.node_positions()) bounds.extend(node);
  world_origin_ = bounds.center();
  transforms_ = transform_rows(warp_.node_to_world(), table_->origin(), world_origin_);
  index_nodes();
}

void BulkWarp::index_nodes() {
  constexpr double kCellsPerRadius = 3; // of influence
  constexpr double kMaxCells = 96;      // along an axis
  const double radius = table_->graph().influence_radius();
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& node : warp_.node_positions()) bounds.extend(node - world_origin_);
  const double side = std::max(radius / kCellsPerRadius, (bounds.sizes().maxCoeff() + 2 * radius) / kMaxCells);
  cells_per_metre_ = static_cast<float>(1 / side);
  std::size_t count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<int>(a);
    low_[a] = static_cast<float>(bounds.min()[axis] - radius);
    cells_[a] = static_cast<std::int32_t>((bounds.sizes()[axis] + 2 * radius) / side) + 1;
    count *= static_cast<std::size_t>(cells_[a]);
  }
  node_of_cell_.assign(count, -1);
  std::vector<float> distances(count, std::numeric_limits<float>::max());
  const auto reach =
      static_cast<float>(0.5 * radius / side + 1); // in cells: beyond, the nearest nodes are searched for
  for (std::size_t n = 0; n < warp_.node_positions().size(); ++n) {
    const Eigen::Vector3d node = warp_.node_positions()[n] - world_origin_;
    std::array<float, 3> at{}; // in cells
    std::array<std::int32_t, 3> first{};
    std::array<std::int32_t, 3> last{};
    for (std::size_t a = 0; a < 3; ++a) {
      at[a] = (static_cast<float>(node[static_cast<int>(a)]) - low_[a]) * cells_per_metre_ - 0.5F;
      first[a] = std::max(static_cast<std::int32_t>(at[a] - reach), 0);
      last[a] = std::min(static_cast<std::int32_t>(at[a] + reach), cells_[a] - 1);
    }
    for (std::int32_t z = first[2]; z <= last[2]; ++z) {
      for (std::int32_t y = first[1]; y <= last[1]; ++y) {
        const float dz = static_cast<float>(z) - at[2];
        const float dy = static_cast<float>(y) - at[1];
        const auto slices = static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_[1]);
        const std::size_t row = (slices + static_cast<std::size_t>(y)) * static_cast<std::size_t>(cells_[0]);
        for (std::int32_t x = first[0]; x <= last[0]; ++x) {
          const float dx = static_cast<float>(x) - at[0];
          const float distance = dx * dx + dy * dy + dz * dz;
          const std::size_t cell = row + static_cast<std::size_t>(x);
          if (distance > reach * reach || !(distance < distances[cell])) continue;
          distances[cell] = distance;
          node_of_cell_[cell] = static_cast<std::int32_t>(n);
        }
      }
    }
  }
}

std::int32_t BulkWarp::node_near(const std::array<float, 3>& world) const {
  std::size_t cell = 0;
  for (const std::size_t a : {2, 1, 0}) {
    const float along = (world[a] - low_[a]) * cells_per_metre_;
    if (!(along >= 0 && along < static_cast<float>(cells_[a]))) return -1;
    cell = cell * static_cast<std::size_t>(cells_[a]) + static_cast<std::size_t>(along);
  }
  return node_of_cell_[cell];
}

void BulkWarp::to_canonical(std::span<Ray> rays, CanonicalRay* canonical) const {
  const kernels::NodeMotion motion{&table_->cells(), transforms_.data()};
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  // First from the node that is nearest to the cell of the point, then from those that are nearest to itself.
  constexpr std::size_t kStarts = 4;
  const auto nearest_node = [&](const Ray& ray, std::size_t number) {
    const Eigen::Vector3d world = Eigen::Vector3f(ray.point.data()).cast<double>() + world_origin_;
    std::array<NearestPoints::Neighbour, kStarts> nearest{};
    return number < warp_.nearest_nodes(world, nearest) ? nearest[number].index : -1;
  };
  std::vector<std::size_t> open; // rays without an answer that are worth a try
  for (std::size_t i = 0; i < rays.size(); ++i) {
    canonical[i] = {{nothing, nothing, nothing}, {}, {}, {}};
    rays[i].start = node_near(rays[i].point);
    if (rays[i].start < 0) rays[i].start = nearest_node(rays[i], 0);
    if (rays[i].start >= 0) open.push_back(i);
  }
  std::vector<Ray> tried;
  std::vector<CanonicalRay> found;
  for (std::size_t attempt = 0; attempt <= kStarts && !open.empty(); ++attempt) {
    tried.clear();
    for (const std::size_t i : open) tried.push_back(rays[i]);
    found.resize(tried.size());
    kernels::rays_to_canonical(motion, tried, found.data());
    std::size_t still = 0;
    for (std::size_t k = 0; k < open.size(); ++k) {
      const std::size_t i = open[k];
      canonical[i] = found[k];
      if (!std::isnan(found[k].point[0]) || attempt >= kStarts) continue;
      rays[i].start = nearest_node(rays[i], attempt);
      if (rays[i].start >= 0) open[still++] = i;
    }
    open.resize(still);
  }
}

void BulkWarp::to_world(std::span<const std::array<float, 3>> canonical, WarpedPoint* world) const {
  kernels::points_to_world({&table_->cells(), transforms_.data()}, canonical, world);
}

} // namespace kinora::motion
