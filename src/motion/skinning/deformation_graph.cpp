#include "motion/skinning/deformation_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"

namespace kinora::motion {
namespace {

constexpr int kRings = 2; // of cells about a query's own that are within reach

bool nearer(const NearestPoints::Neighbour& a, const NearestPoints::Neighbour& b) {
  return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : a.index < b.index;
}

/// The nearest so far, nearest first.
class Nearest {
public:
  Nearest(std::span<NearestPoints::Neighbour> found, double reach) : found_(found), farthest_(reach * reach) {}

  void add(const NearestPoints::Neighbour& candidate) {
    if (candidate.squared_distance > farthest_) return;
    if (count_ == found_.size() && !nearer(candidate, found_[count_ - 1])) return;
    std::size_t at = count_ < found_.size() ? count_++ : count_ - 1;
    for (; at > 0 && nearer(candidate, found_[at - 1]); --at) found_[at] = found_[at - 1];
    found_[at] = candidate;
    if (count_ == found_.size()) farthest_ = found_[count_ - 1].squared_distance;
  }
  std::size_t count() const { return count_; }
  /// Squared distance from which on a candidate is of no use.
  double farthest() const { return farthest_; }

private:
  std::span<NearestPoints::Neighbour> found_;
  std::size_t count_ = 0;
  double farthest_;
};

} // namespace

NearestPoints::NearestPoints(std::span<const Eigen::Vector3d> points, double reach)
    : reach_(reach), points_(points.begin(), points.end()) {
  if (points_.empty()) return;
  constexpr double kMaxCells = 64; // along an axis
  Eigen::Vector3d low = points_.front();
  Eigen::Vector3d high = points_.front();
  for (const Eigen::Vector3d& point : points_) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  low_ = low;
  const double size = std::max(reach_ / kRings, (high - low).maxCoeff() / kMaxCells);
  cells_per_metre_ = 1 / size;
  for (int a = 0; a < 3; ++a) cells_[static_cast<std::size_t>(a)] = static_cast<int>((high[a] - low[a]) / size) + 1;
  const auto cell_of = [this](const Eigen::Vector3d& point) {
    const Eigen::Vector3i c = ((point - low_) * cells_per_metre_).cast<int>();
    return row_of(std::min(c.y(), cells_[1] - 1), std::min(c.z(), cells_[2] - 1)) +
           static_cast<std::size_t>(std::min(c.x(), cells_[0] - 1));
  };
  begin_.assign(row_of(0, cells_[2]) + 1, 0);
  for (const Eigen::Vector3d& point : points_) ++begin_[cell_of(point) + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  sorted_.resize(points_.size());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < points_.size(); ++i)
    sorted_[next[cell_of(points_[i])]++] = {points_[i], static_cast<int>(i)};
}

std::size_t NearestPoints::row_of(int y, int z) const {
  return (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_[1]) + static_cast<std::size_t>(y)) *
         static_cast<std::size_t>(cells_[0]);
}

std::size_t NearestPoints::find(const Eigen::Vector3d& query, std::span<Neighbour> found) const {
  if (points_.empty() || found.empty() || !query.allFinite()) return 0;
  std::array<int, 3> query_cell{};
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double c = std::floor((query[a] - low_[a]) * cells_per_metre_);
    if (c < -kRings || c >= cells_[i] + kRings) return 0;
    query_cell[i] = static_cast<int>(c);
  }
  const int first_x = std::max(query_cell[0] - kRings, 0);
  const int last_x = std::min(query_cell[0] + kRings, cells_[0] - 1);
  // How far away a cell begins along an axis; a little less, for rounding.
  const auto gap = [&](int axis, int cell) {
    const double side = cell < query_cell[static_cast<std::size_t>(axis)] ? cell + 1 : cell;
    const double along = std::abs(low_[axis] + side / cells_per_metre_ - query[axis]);
    return cell == query_cell[static_cast<std::size_t>(axis)] ? 0.0 : (1 - 1e-9) * along;
  };
  Nearest nearest(found, reach_);
  // Rows of cells from the inside out: most of those farther out are not looked at.
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int z = std::max(query_cell[2] - ring, 0); z <= std::min(query_cell[2] + ring, cells_[2] - 1); ++z) {
      const int step = std::abs(z - query_cell[2]) == ring ? 1 : 2 * ring;
      for (int y = query_cell[1] - ring; y <= query_cell[1] + ring; y += step) {
        if (y < 0 || y >= cells_[1]) continue;
        const double gap_y = gap(1, y);
        const double gap_z = gap(2, z);
        if (gap_y * gap_y + gap_z * gap_z > nearest.farthest()) continue;
        const std::size_t row = row_of(y, z);
        const std::uint32_t end = begin_[row + static_cast<std::size_t>(last_x) + 1];
        for (std::uint32_t k = begin_[row + static_cast<std::size_t>(first_x)]; k < end; ++k) {
          nearest.add({sorted_[k].index, (sorted_[k].point - query).squaredNorm()});
        }
      }
    }
  }
  return nearest.count();
}

std::size_t NearestPoints::find(const Eigen::Vector3d& query, std::span<const std::int32_t> among,
                                std::span<Neighbour> found) const {
  if (found.empty()) return 0;
  Nearest nearest(found, reach_);
  for (const std::int32_t i : among) nearest.add({i, (points_[static_cast<std::size_t>(i)] - query).squaredNorm()});
  return nearest.count();
}

DeformationGraph::DeformationGraph(std::vector<Eigen::Vector3d> nodes, double weight_radius, double influence_radius)
    : weight_radius_(weight_radius), influence_radius_(influence_radius) {
  if (nodes.empty() || !(weight_radius > 0) || !(influence_radius > 0)) {
    throw Error(ErrorCode::kFailure, "a deformation graph needs nodes and positive radii");
  }
  nearest_ = NearestPoints(nodes, influence_radius);
}

Influence DeformationGraph::influence(const Eigen::Vector3d& canonical) const {
  std::array<NearestPoints::Neighbour, Influence::kMax + 1> found{};
  const std::size_t count = nearest_.find(canonical, found);
  return weighted(std::span(found).first(count));
}

Influence DeformationGraph::influence(const Eigen::Vector3d& canonical,
                                      std::span<const std::int32_t> candidates) const {
  std::array<NearestPoints::Neighbour, Influence::kMax + 1> found{};
  const std::size_t count = nearest_.find(canonical, candidates, found);
  return weighted(std::span(found).first(count));
}

Influence DeformationGraph::weighted(std::span<const NearestPoints::Neighbour> found) const {
  Influence result;
  result.count = static_cast<int>(std::min<std::size_t>(found.size(), Influence::kMax));
  if (result.count == 0) return result;
  // The first node that has no say takes its weight from the others: what moves a point changes without a jump.
  const double nearest = found[0].squared_distance;
  const double first_without =
      found.size() > Influence::kMax ? found[Influence::kMax].squared_distance : influence_radius_ * influence_radius_;
  const auto weight = [&](double squared_distance) {
    return std::exp((nearest - squared_distance) / (weight_radius_ * weight_radius_));
  };
  double total = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(result.count); ++k) {
    result.nodes[k] = found[k].index;
    total += result.weights[k] = std::max(0.0, weight(found[k].squared_distance) - weight(first_without));
  }
  if (!(total > 0)) {
    result.count = 1;
    result.weights[0] = total = 1;
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(result.count); ++k) result.weights[k] /= total;
  return result;
}

} // namespace kinora::motion
