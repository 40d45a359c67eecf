#include "tracking/camera/camera_stationarity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/robust_cost.h"
#include "tracking/camera/camera_keyframe.h"

namespace kinora::tracking {
namespace {

constexpr int kColumns = 8;
constexpr int kRows = 6;
constexpr TruncatedHuber kCost{kHuberThreshold};
constexpr double kSignificant = 3; // standard errors
constexpr int kMinSamples = 8;
constexpr double kChance = 1e-4; // of as many cells agreeing if each fell on either side alike
constexpr int kMinMajority = 4;  // cells for it to each one against it

/// The gains of one cell's points.
struct Cell {
  double count = 0;
  double sum = 0;
  double squares = 0;

  void add(double gain) {
    count += 1;
    sum += gain;
    squares += gain * gain;
  }
  /// +1: gains, −1: losses, 0: cannot tell.
  int vote() const {
    if (count < kMinSamples) return 0;
    const double mean = sum / count;
    const double variance = std::max(0.0, squares / count - mean * mean) / (count - 1);
    if (mean * mean <= kSignificant * kSignificant * variance) return 0;
    return mean > 0 ? 1 : -1;
  }
};

/// The part of the picture that points fall into, in cells: floor may be all that is within the sensor's range, and a
/// strip of the picture has fewer cells than it takes to tell.
class Grid {
public:
  Grid(std::span<const ModelPoint> points, const LayerView& view) {
    for (const ModelPoint& point : points) {
      const auto p = project(point, view, SE3::Identity());
      if (!p) continue;
      const Eigen::Vector2i pixel(p->pixel_u, p->pixel_v);
      first_ = first_.cwiseMin(pixel);
      last_ = last_.cwiseMax(pixel);
    }
  }

  Cell& at(const ProjectedPoint& p) {
    const Eigen::Vector2i size = last_ - first_ + Eigen::Vector2i::Ones();
    const int column = (p.pixel_u - first_.x()) * kColumns / size.x();
    const int row = (p.pixel_v - first_.y()) * kRows / size.y();
    return cells_[static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column)];
  }
  const auto& cells() const { return cells_; }

private:
  Eigen::Vector2i first_ = Eigen::Vector2i::Constant(std::numeric_limits<int>::max());
  Eigen::Vector2i last_ = Eigen::Vector2i::Constant(-1);
  std::array<Cell, kColumns * kRows> cells_;
};

} // namespace

bool StationarityVotes::show_motion() const {
  if (shift < 1 || moved < kMinMajority * still) return false;
  // The binomial tail P(X ≥ moved) of `moved + still` fair coins.
  const int count = moved + still;
  double tail = 0;
  double term = std::pow(0.5, count); // P(X = count), then downwards
  for (int k = count; k >= moved; --k) {
    tail += term;
    term *= static_cast<double>(k) / static_cast<double>(count - k + 1);
  }
  return tail < kChance;
}

StationarityVotes compare_with_stationary(std::span<const ModelPoint> points, const LayerView& view,
                                          const SE3& still_to_camera) {
  const SE3 identity = SE3::Identity();
  const TextureModel still_texture = measure_texture(points, view, identity, 0);
  const TextureModel moved_texture = measure_texture(points, view, still_to_camera, 0);
  Grid grid(points, view);
  for (const ModelPoint& point : points) {
    const auto still = project(point, view, identity);
    const auto moved = project(point, view, still_to_camera);
    if (!still || !moved) continue;
    Cell& cell = grid.at(*still);
    const auto g_still = geometric_residual(*still, view, Pivot(), kEvaluationGates);
    const auto g_moved = geometric_residual(*moved, view, Pivot(), kEvaluationGates);
    const auto t_still = photometric_residual(*still, point, view, Pivot(), 0, still_texture.light);
    const auto t_moved = photometric_residual(*moved, point, view, Pivot(), 0, moved_texture.light);
    double gain = 0;
    if (g_still || g_moved) {
      gain += (g_still ? kCost.cost(g_still->value / g_still->sigma) : kCost.max_cost()) -
              (g_moved ? kCost.cost(g_moved->value / g_moved->sigma) : kCost.max_cost());
    }
    if (t_still && t_moved) {
      gain += kCost.cost(t_still->value / moved_texture.sigma) - kCost.cost(t_moved->value / moved_texture.sigma);
    }
    if (g_still || g_moved || (t_still && t_moved)) cell.add(gain);
  }
  StationarityVotes votes;
  votes.shift = visible_shift(points, view.intrinsics, still_to_camera);
  for (const Cell& cell : grid.cells()) {
    const int vote = cell.vote();
    if (vote > 0) ++votes.moved;
    if (vote < 0) ++votes.still;
  }
  return votes;
}

} // namespace kinora::tracking
