#include "tracking/rigid_alignment.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "ingest/sensor_noise.h"

namespace kinora::tracking {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kFacingCosine = 0.17; // 80°
constexpr double kHuber = 1.5;
constexpr double kMinTextureSigma = 0.02;
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

/// A model point in the camera, and the crop pixel it falls on.
struct Projected {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;
  double u, v;
  int pixel_u, pixel_v;
};

std::optional<Projected> project(const ModelPoint& model, const ObjectView& view, const SE3& model_to_camera) {
  Projected p;
  p.point = model_to_camera * model.position.cast<double>();
  p.normal = model_to_camera.linear() * model.normal.cast<double>();
  if (p.point.z() < 0.05 || p.normal.dot(p.point) > -kFacingCosine * p.point.norm()) return std::nullopt;
  p.u = view.intrinsics.fx * p.point.x() / p.point.z() + view.intrinsics.cx;
  p.v = view.intrinsics.fy * p.point.y() / p.point.z() + view.intrinsics.cy;
  if (!(p.u > -0.5 && p.v > -0.5 && p.u < view.intrinsics.width - 0.5 && p.v < view.intrinsics.height - 0.5)) {
    return std::nullopt;
  }
  p.pixel_u = static_cast<int>(p.u + 0.5);
  p.pixel_v = static_cast<int>(p.v + 0.5);
  return p;
}

std::optional<Residual> geometric_of(const Projected& p, const ObjectView& view, const Pivot& pivot,
                                     const Gates& gates) {
  if (view.planes.weights.at(p.pixel_u, p.pixel_v) <= 0) return std::nullopt;
  const Eigen::Vector3d measured = view.point(p.pixel_u, p.pixel_v);
  if ((p.point - measured).squaredNorm() > gates.distance * gates.distance) return std::nullopt;
  const float* plane = view.planes.planes.pixel(p.pixel_u, p.pixel_v);
  const double cosine = p.normal.x() * plane[0] + p.normal.y() * plane[1] + p.normal.z() * plane[2];
  if (cosine < gates.normal_cosine) return std::nullopt;
  Residual r;
  r.value = p.normal.dot(p.point - measured);
  r.sigma = ingest::depth_sigma(measured.z()) * std::max(0.3, std::abs(p.normal.dot(measured)) / measured.norm());
  r.jacobian.head<3>() = p.normal;
  // The normal turns with the model: d(n·(x − q)) = n·δ + (ω×n)·(x − q) + n·(ω×(x − c)) = n·δ + ω·((q − c)×n).
  r.jacobian.tail<3>() = (measured - pivot.centre).cross(p.normal) / pivot.radius;
  return r;
}

std::optional<Residual> photometric_of(const Projected& p, const ModelPoint& model, const ObjectView& view,
                                       const Pivot& pivot, int level, const LightOffsets& light) {
  const float expected = model.texture[static_cast<std::size_t>(level)];
  if (std::isnan(expected) || view.mask.at(p.pixel_u, p.pixel_v) != 2) return std::nullopt;
  const double z = p.point.z();
  const float front = view.depth.at(p.pixel_u, p.pixel_v);
  if (front > 0 && front < z - std::max(0.03, 3 * ingest::depth_sigma(z))) return std::nullopt;
  const TextureSample image = view.sample_texture(level, p.u, p.v);
  const double fx = view.intrinsics.fx / z;
  const double fy = view.intrinsics.fy / z;
  const Eigen::Vector3d gradient(image.du * fx, image.dv * fy,
                                 -(image.du * fx * p.point.x() + image.dv * fy * p.point.y()) / z);
  Residual r;
  r.value = image.value - expected - light[model.direction];
  r.sigma = 1;
  r.jacobian.head<3>() = gradient;
  r.jacobian.tail<3>() = (p.point - pivot.centre).cross(gradient) / pivot.radius;
  return r;
}

struct TextureModel {
  LightOffsets light{};
  double sigma = kMinTextureSigma;
};

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
                    const Stage& stage, const TextureModel& texture, double photometric_share) {
  System system;
  for (const ModelPoint& point : points) {
    const std::optional<Projected> p = project(point, view, pose);
    if (!p) {
      system.cost += largest_cost(stage.huber) + photometric_share * largest_cost(kHuber);
      continue;
    }
    if (const auto r = geometric_of(*p, view, pivot, stage.gates)) {
      system.add(*r, r->sigma, stage.huber, 1.0, system.depth_information);
      system.normal_information += huber_weight(r->value / r->sigma, stage.huber) / (r->sigma * r->sigma);
      ++system.geometric;
    } else {
      system.cost += largest_cost(stage.huber);
    }
    if (const auto r = photometric_of(*p, point, view, pivot, stage.level, texture.light)) {
      const double footprint = p->point.z() / view.intrinsics.fx;
      if (r->jacobian.head<3>().norm() * footprint > kFlatTexture) {
        system.add(*r, texture.sigma, kHuber, photometric_share, system.texture_information);
        ++system.photometric;
      }
    } else {
      system.cost += photometric_share * largest_cost(kHuber);
    }
  }
  system.depth_information = system.depth_information.selfadjointView<Eigen::Lower>();
  system.texture_information = system.texture_information.selfadjointView<Eigen::Lower>();
  return system;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// How the texture of image and model differ at a pose: by light, and by what cannot be explained.
TextureModel measure_texture(std::span<const ModelPoint> points, const ObjectView& view, const SE3& pose, int level) {
  const Pivot anywhere{Eigen::Vector3d::Zero(), 1.0};
  TextureModel model;
  std::array<std::vector<double>, ModelPoint::kDirections> differences;
  for (const ModelPoint& point : points) {
    const auto r = photometric_residual(point, view, pose, anywhere, level);
    if (r) differences[point.direction].push_back(r->value);
  }
  std::vector<double> sizes;
  for (std::size_t i = 0; i < differences.size(); ++i) {
    if (differences[i].empty()) continue;
    model.light[i] = median(differences[i]);
    for (const double difference : differences[i]) sizes.push_back(std::abs(difference - model.light[i]));
  }
  if (!sizes.empty()) model.sigma = std::max(kMinTextureSigma, 1.4826 * median(sizes));
  return model;
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
    return build_system(points, view, pose, pivot_at(pose), stage, texture, config.photometric_share);
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

std::uint8_t direction_of(const Eigen::Vector3f& normal) {
  std::uint32_t index = 0;
  for (int axis = 0; axis < 3; ++axis) {
    index = 3 * index + (normal[axis] < -0.38F ? 0U : normal[axis] > 0.38F ? 2U : 1U);
  }
  return static_cast<std::uint8_t>(index);
}

SE3 step_about(const Pivot& pivot, const Twist& step, const SE3& model_to_camera) {
  Twist rotation = Twist::Zero();
  rotation.tail<3>() = step.tail<3>() / pivot.radius;
  SE3 motion = exp_se3(rotation);
  motion.translation() = pivot.centre + step.head<3>() - motion.linear() * pivot.centre;
  SE3 result = motion * model_to_camera;
  // Many small steps must not let the rotation part drift away from a rotation.
  result.linear() = Eigen::Quaterniond(result.linear()).normalized().toRotationMatrix();
  return result;
}

std::optional<Residual> geometric_residual(const ModelPoint& point, const ObjectView& view, const SE3& model_to_camera,
                                           const Pivot& pivot, const Gates& gates) {
  const std::optional<Projected> p = project(point, view, model_to_camera);
  return p ? geometric_of(*p, view, pivot, gates) : std::nullopt;
}

std::optional<Residual> photometric_residual(const ModelPoint& point, const ObjectView& view,
                                             const SE3& model_to_camera, const Pivot& pivot, int level,
                                             const LightOffsets& light) {
  const std::optional<Projected> p = project(point, view, model_to_camera);
  return p ? photometric_of(*p, point, view, pivot, level, light) : std::nullopt;
}

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

AlignmentQuality judge_pose(std::span<const ModelPoint> points, const ObjectView& view, const SE3& model_to_camera) {
  AlignmentQuality quality;
  if (points.empty() || view.empty()) return quality;
  const Pivot pivot{Eigen::Vector3d::Zero(), 1.0};
  std::vector<double> distances;
  double n = 0;
  double sum_a = 0;
  double sum_b = 0;
  double sum_aa = 0;
  double sum_bb = 0;
  double sum_ab = 0;
  const TextureModel texture = measure_texture(points, view, model_to_camera, 0);
  for (const ModelPoint& point : points) {
    const std::optional<Projected> p = project(point, view, model_to_camera);
    if (!p) continue;
    if (view.planes.weights.at(p->pixel_u, p->pixel_v) > 0) {
      ++quality.on_label;
      const auto r = geometric_of(*p, view, pivot, {0.10, 0.7});
      if (r && std::abs(r->value) < 3 * r->sigma + 0.005) distances.push_back(std::abs(r->value));
    }
    if (const auto r = photometric_of(*p, point, view, pivot, 0, texture.light)) {
      const double b = point.texture[0];
      const double a = r->value + b;
      n += 1;
      sum_a += a;
      sum_b += b;
      sum_aa += a * a;
      sum_bb += b * b;
      sum_ab += a * b;
    }
  }
  quality.inliers = distances.size();
  if (!distances.empty()) {
    quality.median_distance = median(distances);
  }
  if (n > 30) {
    const double variance_a = sum_aa / n - sum_a * sum_a / (n * n);
    const double variance_b = sum_bb / n - sum_b * sum_b / (n * n);
    const double texture_floor = kMinTextureSigma * kMinTextureSigma;
    if (variance_a > texture_floor && variance_b > texture_floor) {
      quality.texture_correlation = (sum_ab / n - sum_a * sum_b / (n * n)) / std::sqrt(variance_a * variance_b);
    }
  }
  return quality;
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
    if (config.coarse || stage.level == 0) run_stage(points, view, stage, extent, prior, config, alignment);
  }
  return alignment;
}

} // namespace kinora::tracking
