#include "tracking/rigid_alignment.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace kinora::tracking {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kHuber = 1.5;
constexpr double kFlatTexture = 0.01; // per pixel; below, the gradient is mostly noise
constexpr double kStillStep = 2e-5;   // metres

struct Stage {
  int level;
  Gates gates;
  double huber; ///< of the distances, in σ: far from the solution, few distances are within the noise
  int iterations;
};

constexpr std::array<Stage, 3> kStages = {{
    {2, {0.10, 0.70}, 12, 15},
    {1, {0.05, 0.80}, 4, 12},
    {0, {0.03, 0.866}, kHuber, 10},
}};

// Of a point without correspondence, and the most that a point with one can cost: neither losing nor finding a bad
// correspondence pays.
double largest_cost(double limit) { return 2 * limit * limit; }

double huber(double r, double limit) {
  const double a = std::abs(r);
  return std::min(largest_cost(limit), a <= limit ? 0.5 * r * r : limit * (a - 0.5 * limit));
}
double huber_weight(double r, double limit) {
  const double a = std::abs(r);
  return a <= limit ? 1.0 : limit / a;
}

/// The quadratic model of the cost about one pose.
struct System {
  Matrix6 depth_information = Matrix6::Zero();
  Matrix6 texture_information = Matrix6::Zero();
  Twist gradient = Twist::Zero();
  double cost = 0;
  double normal_information = 0; ///< Σ of the geometric weights: information if all normals pointed one way
  std::size_t geometric = 0;
  std::size_t photometric = 0;

  void add(const Residual& r, double sigma, double limit, double share, Matrix6& information) {
    const double normalised = r.value / sigma;
    const double weight = share * huber_weight(normalised, limit) / (sigma * sigma);
    information.selfadjointView<Eigen::Lower>().rankUpdate(r.jacobian, weight);
    gradient += weight * r.value * r.jacobian;
    cost += share * huber(normalised, limit);
  }
};

System build_system(std::span<const ModelPoint> points, const ObjectView& view, const SE3& pose, const Pivot& pivot,
                    const Stage& stage, const TextureModel& texture, const AlignmentConfig& config) {
  const double photometric_share = config.photometric_share;
  System system;
  for (const ModelPoint& point : points) {
    const auto p = project(point, view, pose);
    if (!p) {
      system.cost += config.unseen_cost * (largest_cost(stage.huber) + photometric_share * largest_cost(kHuber));
      continue;
    }
    if (const auto r = geometric_residual(*p, view, pivot, stage.gates)) {
      system.add(*r, r->sigma, stage.huber, 1.0, system.depth_information);
      system.normal_information += huber_weight(r->value / r->sigma, stage.huber) / (r->sigma * r->sigma);
      ++system.geometric;
    } else {
      const bool unseen = view.planes.weights.at(p->pixel_u, p->pixel_v) <= 0;
      system.cost += (unseen ? config.unseen_cost : 1.0) * largest_cost(stage.huber);
    }
    if (const auto r = photometric_residual(*p, point, view, pivot, stage.level, texture.light)) {
      const double footprint = p->point.z() / view.intrinsics.fx;
      if (r->jacobian.head<3>().norm() * footprint > kFlatTexture) {
        system.add(*r, texture.sigma, kHuber, photometric_share, system.texture_information);
        ++system.photometric;
      }
    } else {
      system.cost += config.unseen_cost * photometric_share * largest_cost(kHuber);
    }
  }
  system.depth_information = system.depth_information.selfadjointView<Eigen::Lower>();
  system.texture_information = system.texture_information.selfadjointView<Eigen::Lower>();
  return system;
}

struct Extent {
  Eigen::Vector3d centre;
  double radius;
};

Extent extent_of(std::span<const ModelPoint> points) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const ModelPoint& point : points) centre += point.position.cast<double>();
  centre /= static_cast<double>(points.size());
  double squared = 0;
  for (const ModelPoint& point : points) squared += (point.position.cast<double>() - centre).squaredNorm();
  return {centre, std::max(1e-3, std::sqrt(squared / static_cast<double>(points.size())))};
}

// The step about the pivot that would carry `pose` to `target`.
Twist step_between(const Pivot& pivot, const SE3& pose, const SE3& target) {
  const SE3 motion = target * pose.inverse();
  Twist step;
  step.head<3>() = motion * pivot.centre - pivot.centre;
  step.tail<3>() = pivot.radius * log_se3(motion).tail<3>();
  return step;
}

void run_stage(std::span<const ModelPoint> points, const ObjectView& view, const Stage& stage, const Extent& extent,
               const SE3& prior, const AlignmentConfig& config, Alignment& alignment) {
  const auto pivot_at = [&extent](const SE3& pose) { return Pivot{pose * extent.centre, extent.radius}; };
  Pivot pivot = pivot_at(alignment.model_to_camera);
  const TextureModel texture = measure_texture(points, view, alignment.model_to_camera, stage.level);
  const auto build = [&](const SE3& pose) {
    return build_system(points, view, pose, pivot_at(pose), stage, texture, config);
  };
  System system = build(alignment.model_to_camera);
  double damping = 1e-3;
  for (int i = 0; i < stage.iterations; ++i) {
    ++alignment.iterations;
    pivot = pivot_at(alignment.model_to_camera);
    const double weak_below = config.weak_share * std::max(1.0, system.normal_information);
    // Noise in the normals pretends to some information in every direction; so depth must give a share of what it gives
    // along the normals. Texture counts by what it can resolve.
    const double tolerance = config.texture_tolerance;
    const Matrix6 support = system.depth_information + weak_below * tolerance * tolerance * system.texture_information;
    const DampedStep solved =
        solve_with_prior(system.depth_information + system.texture_information, support, system.gradient,
                         step_between(pivot, alignment.model_to_camera, prior), weak_below, damping);
    alignment.eigenvalues = solved.eigenvalues;
    alignment.directions = solved.directions;
    alignment.weak_directions = solved.weak_directions;
    alignment.geometric_terms = system.geometric;
    alignment.photometric_terms = system.photometric;
    const SE3 moved = step_about(pivot, solved.step, alignment.model_to_camera);
    System next = build(moved);
    // What the prior moves may cost a little: the data hardly see it.
    const double allowance = solved.weak_directions > 0 ? 1e-3 : 1e-9;
    if (next.cost > system.cost * (1 + allowance) && solved.step.norm() > kStillStep) {
      damping *= 10;
      if (damping > 1e4) break;
      continue;
    }
    alignment.model_to_camera = moved;
    system = std::move(next);
    damping = std::max(1e-6, damping / 5);
    if (solved.step.norm() < kStillStep) break;
  }
}

} // namespace

DampedStep solve_with_prior(const Matrix6& information, const Matrix6& support, const Twist& gradient,
                            const Twist& toward_prior, double weak_below, double damping) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(support);
  DampedStep result{Twist::Zero(), solver.eigenvalues(), solver.eigenvectors(), 0};
  while (result.weak_directions < 6 && !(result.eigenvalues[result.weak_directions] > weak_below)) {
    ++result.weak_directions;
  }
  const auto weak = result.directions.leftCols(result.weak_directions);
  result.step = weak * (weak.transpose() * toward_prior);
  const int strong_count = 6 - result.weak_directions;
  if (strong_count == 0) return result;
  const auto strong = result.directions.rightCols(strong_count);
  Eigen::MatrixXd system = strong.transpose() * information * strong;
  system.diagonal() *= 1 + damping;
  const Eigen::VectorXd rest = strong.transpose() * (gradient + information * result.step);
  result.step -= strong * system.ldlt().solve(rest);
  return result;
}

Alignment align(std::span<const ModelPoint> points, const ObjectView& view, const SE3& start, const SE3& prior,
                const AlignmentConfig& config) {
  Alignment alignment;
  if (points.empty() || view.empty()) {
    alignment.model_to_camera = prior;
    alignment.weak_directions = 6;
    return alignment;
  }
  alignment.model_to_camera = start;
  const Extent extent = extent_of(points);
  for (const Stage& stage : kStages) {
    if (stage.level <= config.coarsest_level) run_stage(points, view, stage, extent, prior, config, alignment);
  }
  return alignment;
}

} // namespace kinora::tracking
