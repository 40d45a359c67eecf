#include "tracking/rigid/rigid_icp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>

#include "core/damped_gauss_newton.h"
#include "core/parallel.h"
#include "core/robust_cost.h"

namespace kinora::tracking {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr TruncatedHuber kContourCost{kHuberThreshold};
constexpr TruncatedHuber kTextureCost{2}; // of the texture, whose noise is that of its flat parts: its edges tell most
constexpr double kFittingCost = 0.5;      // mean of a point that fits, at a standard deviation of 1
constexpr double kFlatTexture = 0.01;     // per pixel; below, the gradient is mostly noise
constexpr std::size_t kPointsPerChunk = 640;
constexpr double kRefusedDamping = 0.3; // at least, after a step that does not pay: with less the next is the same

struct Stage {
  int level;
  Gates gates;
  TruncatedHuber cost; ///< of the distances, in σ: far from the solution, few distances are within the noise
  int iterations;
  double min_step;        ///< metres: a step so short is the last
  std::size_t max_points; ///< about
  double contour_reach;   ///< pixels
};

constexpr std::array<Stage, 3> kStages = {{
    {2, {0.10, 0.70}, {12}, 15, 5e-4, 600, 24},
    {1, {0.05, 0.80}, {4}, 12, 2e-4, 600, 10},
    {0, {0.03, 0.866}, {kHuberThreshold}, 10, 5e-5, std::numeric_limits<std::size_t>::max(), 4},
}};

/// The quadratic model of the cost about one pose.
struct System {
  Matrix6 depth_information = Matrix6::Zero();
  Matrix6 texture_information = Matrix6::Zero();
  Matrix6 contour_information = Matrix6::Zero();
  Matrix6 contour_support = Matrix6::Zero(); ///< what both rims tell alike
  Twist gradient = Twist::Zero();
  double cost = 0;
  double normal_information = 0; ///< Σ of the geometric weights: information if all normals pointed one way
  std::size_t geometric = 0;
  std::size_t photometric = 0;
  double contour_normal_information = 0; ///< likewise, of the rim
  std::size_t contour = 0;

  Matrix6 information() const { return depth_information + texture_information + contour_information; }
  void add(const Residual& r, double sigma, const TruncatedHuber& robust, double share, Matrix6& information) {
    const double normalised = r.value / sigma;
    const double weight = share * robust.weight(normalised) / (sigma * sigma);
    const Twist weighted = weight * r.jacobian;
    information += weighted * r.jacobian.transpose();
    gradient += weighted * r.value;
    cost += share * robust.cost(normalised);
  }
  void add(const System& other) {
    depth_information += other.depth_information;
    texture_information += other.texture_information;
    gradient += other.gradient;
    cost += other.cost;
    normal_information += other.normal_information;
    geometric += other.geometric;
    photometric += other.photometric;
  }
};

void add_point(const ModelPoint& point, const LayerView& view, const SE3& pose, const Pivot& pivot, const Stage& stage,
               const TextureModel& texture, const AlignmentConfig& config, System& system) {
  const double photometric_weight = config.photometric_weight;
  const auto p = project(point, view, pose);
  if (!p) {
    system.cost += config.unseen_cost * (stage.cost.max_cost() + photometric_weight * kFittingCost);
    return;
  }
  if (const auto r = geometric_residual(*p, view, pivot, stage.gates)) {
    system.add(*r, r->sigma, stage.cost, 1.0, system.depth_information);
    system.normal_information += stage.cost.weight(r->value / r->sigma) / (r->sigma * r->sigma);
    ++system.geometric;
  } else {
    const bool unseen = view.planes.weights.at(p->pixel_u, p->pixel_v) <= 0;
    system.cost += (unseen ? config.unseen_cost : 1.0) * stage.cost.max_cost();
  }
  if (const auto r = photometric_residual(*p, point, view, pivot, stage.level, texture.light)) {
    const double footprint = p->point.z() / view.intrinsics.fx;
    if (r->jacobian.head<3>().norm() * footprint > kFlatTexture) {
      system.add(*r, texture.sigma, kTextureCost, photometric_weight, system.texture_information);
      ++system.photometric;
    }
  } else {
    system.cost += config.unseen_cost * photometric_weight * kFittingCost; // as a thing turns, texture comes and goes
  }
}

void add_contour(const ContourPair& contour, const LayerView& view, const SE3& pose, const Pivot& pivot,
                 const Stage& stage, const AlignmentConfig& config, System& system) {
  for (ContourPoint point : contour.earlier) {
    point.position = pose * point.position;
    if (const auto r = contour.now.residual(point, view, pivot, stage.contour_reach)) {
      system.add(*r, r->sigma, kContourCost, config.contour_weight, system.contour_information);
      const Matrix6 product = r->jacobian * r->counterpart.transpose();
      system.contour_support +=
          0.5 * config.contour_weight * kContourCost.weight(r->value) * (product + product.transpose());
      const double focal = view.intrinsics.fx / point.position.z();
      system.contour_normal_information += config.contour_weight * focal * focal;
      ++system.contour;
    } else {
      system.cost += config.contour_weight * kContourCost.max_cost();
    }
  }
}

System build_system(std::span<const ModelPoint> points, const LayerView& view, const SE3& pose, const Pivot& pivot,
                    const Stage& stage, const TextureModel& texture, const AlignmentConfig& config) {
  std::vector<System> parts(chunk_count(points.size(), kPointsPerChunk));
  parallel_for(points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    for (const ModelPoint& point : points.subspan(chunk.begin, chunk.end - chunk.begin)) {
      add_point(point, view, pose, pivot, stage, texture, config, parts[chunk.index]);
    }
  });
  for (std::size_t i = 1; i < parts.size(); ++i) parts[0].add(parts[i]);
  return parts[0];
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

// Points come in the order of their directions, so that every second or third are still spread over them.
std::vector<ModelPoint> downsampled(std::span<const ModelPoint> points, std::size_t limit) {
  const std::size_t stride = 1 + (points.size() - 1) / limit;
  std::vector<ModelPoint> result;
  result.reserve(points.size() / stride + 1);
  for (std::size_t i = 0; i < points.size(); i += stride) result.push_back(points[i]);
  return result;
}

double degenerate_below(const System& system, const AlignmentConfig& config) {
  return config.degenerate_share * std::max(1.0, system.normal_information);
}

// Noise in the normals pretends to some information in every direction; so depth must give a share of what it gives
// along the normals. Texture and rim count by what they can resolve. The rim's normals, too, are noisy: in what depth
// and texture leave open, the prior has the weight of what they pretend to.
DampedStep solve(System system, const Twist& toward_prior, double damping, const AlignmentConfig& config) {
  const double limit = degenerate_below(system, config);
  const double texture = config.texture_tolerance * config.texture_tolerance;
  Matrix6 support = system.depth_information + limit * texture * system.texture_information;
  if (system.contour > 0) {
    const double prior_information = config.contour_degenerate_share * std::max(1.0, system.contour_normal_information);
    const Eigen::SelfAdjointEigenSolver<Matrix6> solver(support);
    Matrix6 unconstrained = Matrix6::Zero();
    for (int i = 0; i < 6 && !(solver.eigenvalues()[i] > config.nearly_degenerate * limit); ++i) {
      unconstrained += solver.eigenvectors().col(i) * solver.eigenvectors().col(i).transpose();
    }
    const double resolved = std::min(config.contour_tolerance * config.contour_tolerance, 1 / prior_information);
    support += limit * resolved * system.contour_support;
    system.contour_information += prior_information * unconstrained;
    system.gradient -= prior_information * unconstrained * toward_prior;
  }
  return solve_with_prior(system.information(), support, system.gradient, toward_prior, limit, damping);
}

void run_stage(std::span<const ModelPoint> all_points, const LayerView& view, const Stage& stage, const Extent& extent,
               const SE3& prior, const ContourSource& contours, const AlignmentConfig& config, Alignment& alignment) {
  std::vector<ModelPoint> subset;
  if (all_points.size() > stage.max_points) subset = downsampled(all_points, stage.max_points);
  const std::span<const ModelPoint> points = subset.empty() ? all_points : subset;
  const auto pivot_at = [&extent](const SE3& pose) { return Pivot{pose * extent.centre, extent.radius}; };
  Pivot pivot = pivot_at(alignment.model_to_camera);
  const TextureModel texture = measure_texture(points, view, alignment.model_to_camera, stage.level);
  const ContourPair* contour = nullptr;
  const auto build = [&](const SE3& pose) {
    System system = build_system(points, view, pose, pivot_at(pose), stage, texture, config);
    if (contour != nullptr) add_contour(*contour, view, pose, pivot_at(pose), stage, config, system);
    return system;
  };
  System system = build(alignment.model_to_camera);
  MarquardtDamping damping({.max = 1e4, .min_after_refusal = kRefusedDamping});
  damped_gauss_newton(damping, stage.iterations, [&](double value) -> StepOutcome {
    ++alignment.iterations;
    pivot = pivot_at(alignment.model_to_camera);
    const Twist toward_prior = step_between(pivot, alignment.model_to_camera, prior);
    DampedStep solved = solve(system, toward_prior, value, config);
    const bool is_unconstrained =
        !(solved.eigenvalues[0] > config.nearly_degenerate * degenerate_below(system, config));
    if (contour == nullptr && is_unconstrained && contours) {
      contour = contours();
      if (contour != nullptr) {
        add_contour(*contour, view, alignment.model_to_camera, pivot, stage, config, system);
        solved = solve(system, toward_prior, value, config);
      }
    }
    alignment.eigenvalues = solved.eigenvalues;
    alignment.directions = solved.directions;
    alignment.degenerate_directions = solved.degenerate_directions;
    alignment.geometric_terms = system.geometric;
    alignment.photometric_terms = system.photometric;
    const SE3 moved = step_about(pivot, solved.step, alignment.model_to_camera);
    System next = build(moved);
    // What the prior moves may cost a little: the data hardly see it.
    const double allowance = solved.degenerate_directions > 0 || contour != nullptr ? 1e-3 : 1e-9;
    const bool decreases = !(next.cost > system.cost * (1 + allowance));
    if (decreases) {
      alignment.model_to_camera = moved;
      system = std::move(next);
    }
    return {.is_taken = decreases, .is_last = solved.step.norm() < stage.min_step};
  });
}

} // namespace

PoseInformation information_at(std::span<const ModelPoint> points, const LayerView& view, const SE3& model_to_camera,
                               const AlignmentConfig& config) {
  const Stage& stage = kStages.back();
  const TextureModel texture = measure_texture(points, view, model_to_camera, stage.level);
  const System system = build_system(points, view, model_to_camera, Pivot{}, stage, texture, config);
  return {system.depth_information, system.texture_information};
}

DampedStep solve_with_prior(const Matrix6& information, const Matrix6& support, const Twist& gradient,
                            const Twist& toward_prior, double degenerate_below, double damping) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(support);
  DampedStep result{Twist::Zero(), solver.eigenvalues(), solver.eigenvectors(), 0};
  while (result.degenerate_directions < 6 && !(result.eigenvalues[result.degenerate_directions] > degenerate_below)) {
    ++result.degenerate_directions;
  }
  const auto degenerate = result.directions.leftCols(result.degenerate_directions);
  result.step = degenerate * (degenerate.transpose() * toward_prior);
  const int constrained_count = 6 - result.degenerate_directions;
  if (constrained_count == 0) return result;
  const auto constrained = result.directions.rightCols(constrained_count);
  Eigen::MatrixXd system = constrained.transpose() * information * constrained;
  system.diagonal() *= 1 + damping;
  const Eigen::VectorXd rest = constrained.transpose() * (gradient + information * result.step);
  result.step -= constrained * system.ldlt().solve(rest);
  return result;
}

Alignment align(std::span<const ModelPoint> points, const LayerView& view, const SE3& start, const SE3& prior,
                const ContourSource& contours, const AlignmentConfig& config) {
  Alignment alignment;
  if (points.empty() || view.empty()) {
    alignment.model_to_camera = prior;
    alignment.degenerate_directions = 6;
    return alignment;
  }
  alignment.model_to_camera = start;
  const Extent extent = extent_of(points);
  for (const Stage& stage : kStages) {
    if (stage.level <= config.coarsest_level)
      run_stage(points, view, stage, extent, prior, contours, config, alignment);
  }
  return alignment;
}

} // namespace kinora::tracking
