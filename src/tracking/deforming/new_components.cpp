#include "tracking/deforming/new_components.h"

#include <algorithm>
#include <cmath>

namespace kinora::tracking {
Eigen::Vector3d NewComponent::centroid() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

std::vector<NewComponent> find_new_components(const LayerView& view, const TsdfVolume::CanonicalMap& positions,
                                              std::size_t min_cells, double max_jump) {
  const int columns = positions.of_cell.width();
  const int rows = positions.of_cell.height();
  const auto index = [columns](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  };
  // Depth in the middle of each cell; 0 where nothing is measured or the cell is done.
  std::vector<double> depth(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  const auto pixel_of = [&](int column, int row) {
    return std::array{std::min(positions.stride * column + positions.stride / 2, view.intrinsics.width - 1),
                      std::min(positions.stride * row + positions.stride / 2, view.intrinsics.height - 1)};
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const auto [u, v] = pixel_of(column, row);
      if (view.planes.weights.at(u, v) > 0) depth[index(column, row)] = view.point(u, v).z();
    }
  }
  std::vector<NewComponent> found;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (depth[index(column, row)] == 0) continue;
      NewComponent component;
      bool known = false;
      std::vector<std::pair<std::array<int, 2>, double>> stack{{{column, row}, depth[index(column, row)]}};
      depth[index(column, row)] = 0;
      while (!stack.empty()) {
        const auto [cell, z] = stack.back();
        stack.pop_back();
        const auto [u, v] = pixel_of(cell[0], cell[1]);
        component.cells.push_back(cell);
        component.points.push_back(view.point(u, v));
        known |= !std::isnan(positions.of_cell.at(cell[0], cell[1], 0));
        for (int y = std::max(cell[1] - 1, 0); y <= std::min(cell[1] + 1, rows - 1); ++y) {
          for (int x = std::max(cell[0] - 1, 0); x <= std::min(cell[0] + 1, columns - 1); ++x) {
            double& other = depth[index(x, y)];
            if (other == 0 || std::abs(other - z) >= max_jump) continue;
            stack.push_back({{x, y}, other});
            other = 0;
          }
        }
      }
      if (!known && component.cells.size() >= min_cells) found.push_back(std::move(component));
    }
  }
  return found;
}

std::vector<NewComponent> PersistentComponents::add(const LayerView& view, const TsdfVolume::CanonicalMap& positions) {
  std::vector<NewComponent> persistent;
  std::vector<Seen> seen;
  for (NewComponent& component : find_new_components(view, positions, config_.min_cells, config_.max_jump)) {
    const Eigen::Vector3d centroid = component.centroid();
    int frames = 1;
    for (const Seen& before : seen_) {
      if ((before.centroid - centroid).norm() < config_.max_step) frames = std::max(frames, before.frames + 1);
    }
    seen.push_back({centroid, frames});
    if (frames >= config_.frames) persistent.push_back(std::move(component));
  }
  seen_ = std::move(seen);
  return persistent;
}

} // namespace kinora::tracking
