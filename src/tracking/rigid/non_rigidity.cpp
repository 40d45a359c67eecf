#include "tracking/rigid/non_rigidity.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

namespace kinora::tracking {
namespace {

constexpr double kCells = 64;          // on the label
constexpr int kMinPoints = 8;          // of a cell
constexpr int kMinRegion = 3;          // cells
constexpr double kMinDistance = 0.005; // to either side: a graph errs by 7 mm (docs/experiments/tracking_people.md)
constexpr double kSigmas = 3;
constexpr double kMinCellShare = 0.75;
constexpr double kDegenerateShare = 0.01; // of the information along the normals (rigid_icp.h)
constexpr double kMinEvidenceShare = 0.05;
constexpr int kMinEvidenceFrames = 5;

struct Cell {
  int points = 0;
  int in_front = 0, behind = 0; ///< points that are off
  double sum = 0;               ///< of all distances, metres; positive: behind
};

struct Sample {
  Residual residual;
  std::size_t cell;
};

/// The view in cells.
struct CellGrid {
  int side; ///< pixels
  int width, height;

  explicit CellGrid(const LayerView& view)
      : side(std::max(4, static_cast<int>(std::lround(std::sqrt(static_cast<double>(view.depth_pixels) / kCells))))),
        width((view.intrinsics.width + side - 1) / side), height((view.intrinsics.height + side - 1) / side) {}
  std::size_t count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  std::size_t at(int u, int v) const {
    const int cell = v / side * width + u / side;
    return static_cast<std::size_t>(cell);
  }
};

// The small motion that brings the model as near as it can be; none in directions that its shape leaves open.
Twist least_squares_motion(std::span<const Sample> samples) {
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Twist gradient = Twist::Zero();
  for (const Sample& sample : samples) {
    const Residual& r = sample.residual;
    information += r.jacobian * r.jacobian.transpose();
    gradient += r.value * r.jacobian;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(information);
  Twist motion = Twist::Zero();
  for (int i = 0; i < 6; ++i) {
    if (solver.eigenvalues()[i] <= kDegenerateShare * static_cast<double>(samples.size())) continue;
    const Twist direction = solver.eigenvectors().col(i);
    motion -= direction * (direction.dot(gradient) / solver.eigenvalues()[i]);
  }
  return motion;
}

struct Region {
  int cells = 0;
  double sum = 0; ///< of the cells' mean distances
  double mean() const { return cells > 0 ? sum / cells : 0.0; }
};

// The largest region of cells that hang together, sides and corners; they are taken out of `off`.
Region largest_region(const CellGrid& grid, const std::vector<Cell>& cells, std::vector<bool> off) {
  Region largest;
  std::vector<std::size_t> open;
  for (std::size_t first = 0; first < off.size(); ++first) {
    if (!off[first]) continue;
    Region region;
    open.assign(1, first);
    off[first] = false;
    while (!open.empty()) {
      const auto cell = static_cast<int>(open.back());
      open.pop_back();
      ++region.cells;
      region.sum += cells[static_cast<std::size_t>(cell)].sum / cells[static_cast<std::size_t>(cell)].points;
      for (int v = std::max(0, cell / grid.width - 1); v <= std::min(grid.height - 1, cell / grid.width + 1); ++v) {
        for (int u = std::max(0, cell % grid.width - 1); u <= std::min(grid.width - 1, cell % grid.width + 1); ++u) {
          const std::size_t next = grid.at(u * grid.side, v * grid.side);
          if (!off[next]) continue;
          off[next] = false;
          open.push_back(next);
        }
      }
    }
    if (region.cells > largest.cells) largest = region;
  }
  return largest;
}

} // namespace

RigidityViolation rigidity_violation(std::span<const ModelPoint> points, const LayerView& view,
                                     const SE3& model_to_camera) {
  const CellGrid grid(view);
  const Pivot pivot{view.centroid, 1};
  std::vector<Sample> samples;
  double squared = 0;
  for (const ModelPoint& point : points) {
    const auto p = project(point, view, model_to_camera);
    if (!p || view.mask.at(p->pixel_u, p->pixel_v) != MaskArea::kInterior) continue;
    const auto r = geometric_residual(*p, view, pivot, kEvaluationGates);
    if (!r) continue;
    samples.push_back({*r, grid.at(p->pixel_u, p->pixel_v)});
    squared += (p->point - pivot.centre).squaredNorm();
  }
  if (samples.empty()) return {};
  const double radius = std::max(1e-3, std::sqrt(squared / static_cast<double>(samples.size())));
  for (Sample& sample : samples) sample.residual.jacobian.tail<3>() /= radius;
  const Twist motion = least_squares_motion(samples);
  std::vector<Cell> cells(grid.count());
  for (const Sample& sample : samples) {
    const double distance = sample.residual.value + sample.residual.jacobian.dot(motion);
    const double tolerance = std::max(kMinDistance, kSigmas * sample.residual.sigma);
    Cell& cell = cells[sample.cell];
    ++cell.points;
    cell.in_front += distance < -tolerance ? 1 : 0;
    cell.behind += distance > tolerance ? 1 : 0;
    cell.sum += distance;
  }
  int seen = 0;
  std::vector<bool> in_front(cells.size()), behind(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].points < kMinPoints) continue;
    ++seen;
    in_front[i] = cells[i].in_front >= kMinCellShare * cells[i].points;
    behind[i] = cells[i].behind >= kMinCellShare * cells[i].points;
  }
  const Region front = largest_region(grid, cells, in_front);
  const Region back = largest_region(grid, cells, behind);
  const int smaller = std::min(front.cells, back.cells);
  if (smaller < kMinRegion) return {};
  return {static_cast<double>(smaller) / seen, back.mean() - front.mean()};
}

void NonRigidityTest::add(std::size_t frame, const RigidityViolation& alignment_cost) {
  if (is_certain_) {
    non_rigidity_.metres = std::max(non_rigidity_.metres, alignment_cost.metres);
    return;
  }
  if (alignment_cost.share >= kMinEvidenceShare) {
    if (surplus_ == 0) non_rigidity_ = {frame, 0};
    non_rigidity_.metres = std::max(non_rigidity_.metres, alignment_cost.metres);
    is_certain_ = ++surplus_ >= kMinEvidenceFrames;
  } else {
    surplus_ = std::max(0, surplus_ - 1);
  }
}

} // namespace kinora::tracking
