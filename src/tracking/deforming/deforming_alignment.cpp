#include "tracking/deforming/deforming_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "core/damped_gauss_newton.h"
#include "core/parallel.h"
#include "core/sensor_noise.h"
#include "core/statistics.h"
#include "tracking/rigid/residuals.h"
#include "tracking/solver/pcg.h"
#include "tracking/solver/point_association.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kPointsPerChunk = 1024;
constexpr DepthMargin kDeformedMargin{0.05, 4};

constexpr std::array<int, DeformingAlignmentConfig::kStages> kLevels = {2, 1, 0};

/// Where a point is in the view; pixel_u < 0: nowhere.
struct Projection {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;
  double u = 0;
  double v = 0;
  int pixel_u = -1;
  int pixel_v = -1;
};

Projection project_point(const motion::PosedPoint& point, const LayerView& view) {
  Projection seen;
  seen.position = point.position.cast<double>();
  seen.normal = point.normal.cast<double>();
  if (!(seen.position.z() > kNearestDepth) || seen.normal.dot(seen.position) > -kFacingCosine * seen.position.norm())
    return seen;
  const Eigen::Vector2d pixel = view.intrinsics.project(seen.position);
  seen.u = pixel.x();
  seen.v = pixel.y();
  if (!is_in_picture(seen.u, seen.v, view.intrinsics)) return seen;
  seen.pixel_u = static_cast<int>(std::lround(seen.u));
  seen.pixel_v = static_cast<int>(std::lround(seen.v));
  return seen;
}

float texture_of(const PointTexture& texture, std::size_t which, int level) {
  if (which == 0) return texture.last[static_cast<std::size_t>(level)];
  return level == 0 ? texture.fused : std::numeric_limits<float>::quiet_NaN();
}

// Light: the median difference of each direction of the normal. Sigma: what it leaves.
void set_textures(std::span<const PointTexture> textures, std::span<const float> image, std::size_t which, int level,
                  const DeformingAlignmentConfig& config, std::vector<DataTerm>& terms) {
  if (which > 0 && level > 0) return; // there is none
  std::array<std::vector<float>, ModelPoint::kDirections> differences;
  const auto difference = [&](std::size_t p) { return image[p] - texture_of(textures[p], which, level); };
  std::size_t count = 0;
  for (std::size_t p = 0; p < terms.size(); ++p) {
    if (std::isnan(difference(p))) continue;
    differences[textures[p].direction].push_back(difference(p));
    ++count;
  }
  if (count == 0) return;
  std::array<float, ModelPoint::kDirections> light{};
  std::vector<float> sizes;
  sizes.reserve(count);
  for (std::size_t d = 0; d < light.size(); ++d) {
    if (differences[d].empty()) continue;
    light[d] = median(differences[d]);
    for (const float value : differences[d]) sizes.push_back(std::abs(value - light[d]));
  }
  const double sigma = std::max(config.texture_sigma, kDeviationPerMedian * static_cast<double>(median(sizes)));
  const float scale = static_cast<float>(std::sqrt(config.photometric_weight) / sigma);
  for (std::size_t p = 0; p < terms.size(); ++p) {
    if (std::isnan(difference(p))) continue;
    terms[p].expected[which] = texture_of(textures[p], which, level) + light[textures[p].direction];
    terms[p].texture_scale[which] = scale;
  }
}

ProblemWeights weights_of(double spacing, const DeformingAlignmentConfig& config) {
  ProblemWeights weights;
  weights.rigidity_sigma = config.rigidity * spacing;
  weights.prior_sigma = config.prior_sigma;
  return weights;
}

// One step that lowers the energy, if there is one within a few tries; `energies`: before and after are appended.
bool take_step(DeformingProblem& problem, const DeformingAlignmentConfig& config, NielsenDamping& damping,
               motion::LayerPose& pose, std::vector<double>& energies) {
  constexpr double kFloor = 1e-6;
  double before = 0;
  const BlockSystem& system = problem.linearise(pose, before);
  return damped_gauss_newton(damping, config.damping_attempts, [&](double value) -> StepOutcome {
    const std::vector<Twist> added = damping_of(problem.pattern(), system, value, kFloor);
    const PcgResult solved = solve_pcg(problem.pattern(), system, added, config.pcg_iterations, config.pcg_tolerance);
    const double predicted_decrease = -model_change(problem.pattern(), system, solved.step);
    motion::LayerPose candidate = motion::pose_layer(problem.model().points, motion::stepped(pose.nodes, solved.step));
    const double after = problem.energy(candidate);
    if (!(after < before)) return {};
    energies.push_back(before);
    energies.push_back(after);
    pose = std::move(candidate);
    return {.is_taken = true,
            .is_last = true,
            .gain_ratio = predicted_decrease > 0 ? (before - after) / predicted_decrease : 1.0};
  });
}

/// The share of each node's points of which something holds. A node that carries less than one point counts as if it
/// did not hold of the rest of that.
class NodeShares {
public:
  explicit NodeShares(const LayerModel& model) : model_(model) {
    totals_ = sums([](std::size_t) { return true; });
  }
  /// `counts`: of a point's number.
  template <class Counts> std::vector<double> of(const Counts& counts) const {
    std::vector<double> shares = sums(counts);
    for (std::size_t n = 0; n < shares.size(); ++n) shares[n] /= std::max(1.0, totals_[n]);
    return shares;
  }

private:
  template <class Counts> std::vector<double> sums(const Counts& counts) const {
    std::vector<double> sums(model_.nodes.size(), 0);
    for (std::size_t p = 0; p < model_.points.size(); ++p) {
      const motion::SkinnedPoint& point = model_.points[p];
      if (!counts(p)) continue;
      for (std::size_t k = 0; k < point.nodes.size(); ++k) {
        sums[static_cast<std::size_t>(point.nodes[k])] += static_cast<double>(point.weights[k]);
      }
    }
    return sums;
  }

  const LayerModel& model_;
  std::vector<double> totals_;
};

// Measurements go before bones, also those that see past a node: bones are wrong there.
std::vector<NodeTarget> downweighted(std::span<const NodeTarget> binding, std::span<const double> observed) {
  std::vector<NodeTarget> result(binding.begin(), binding.end());
  for (std::size_t n = 0; n < result.size(); ++n) result[n].scale *= 1 - observed[n];
  return result;
}

Eigen::Vector3d mean_position(const motion::NodeStates& states) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& position : states.positions) sum += position;
  return sum / static_cast<double>(std::max<std::size_t>(1, states.size()));
}

motion::NodeStates rotated_about(const motion::NodeStates& states, const Eigen::Vector3d& pivot, const Twist& step) {
  Twist rotation = Twist::Zero();
  rotation.tail<3>() = step.tail<3>();
  SE3 motion = exp_se3(rotation);
  motion.translation() = pivot + step.head<3>() - motion.linear() * pivot;
  return motion::moved(states, motion);
}

// All nodes as one body. Six unknowns need few points.
motion::NodeStates rigidly_aligned(const LayerModel& model, std::span<const PointTexture> textures,
                                   const LayerView& view, const motion::NodeStates& start,
                                   const DeformingAlignmentConfig& config) {
  constexpr std::size_t kEnough = 1000;
  const std::size_t stride = std::max<std::size_t>(1, (model.points.size() + kEnough / 2) / kEnough);
  std::vector<motion::SkinnedPoint> some;
  std::vector<PointTexture> theirs;
  for (std::size_t p = 0; p < model.points.size(); p += stride) {
    some.push_back(model.points[p]);
    theirs.push_back(textures[p]);
  }
  return align_rigidly({model.nodes, model.edges, some}, theirs, view, start, kLevels[0], config.gates[0],
                       config.rigid_iterations, config);
}

/// What evaluate_deformation() sums over the points.
struct QualitySums {
  DeformingQuality counts;
  double textured = 0; ///< points
  std::array<double, 5> sums{};

  void add(const QualitySums& other) {
    counts.on_label += other.counts.on_label;
    counts.inliers += other.counts.inliers;
    counts.free_space_violations += other.counts.free_space_violations;
    textured += other.textured;
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += other.sums[i];
  }

  DeformingQuality quality() const {
    DeformingQuality quality = counts;
    if (textured < 20) return quality;
    const auto covariance = [&](double product, double a, double b) {
      return product / textured - a * b / (textured * textured);
    };
    const double variance_model = covariance(sums[2], sums[0], sums[0]);
    const double variance_image = covariance(sums[3], sums[1], sums[1]);
    const double floor = 0.03 * 0.03; // of the log luminance: less is no texture
    if (variance_model < floor || variance_image < floor) return quality;
    quality.texture_correlation = covariance(sums[4], sums[0], sums[1]) / std::sqrt(variance_model * variance_image);
    return quality;
  }
};

void accumulate(const Projection& seen, const PointTexture& texture, const LayerView& view, QualitySums& sum) {
  if (seen.pixel_u < 0) return;
  if (view.mask.at(seen.pixel_u, seen.pixel_v) == MaskArea::kOutside &&
      violates_free_space(seen.position.z(), view.depth.at(seen.pixel_u, seen.pixel_v), kDeformedMargin)) {
    ++sum.counts.free_space_violations;
  }
  if (view.planes.weights.at(seen.pixel_u, seen.pixel_v) <= 0) return;
  const Eigen::Vector3d measured = view.point(seen.pixel_u, seen.pixel_v);
  const double tolerance = inlier_distance(kSensorNoise.sigma(measured.z()));
  const double distance = seen.normal.dot(seen.position - measured);
  // Behind what is measured it may be hidden by another part of the layer.
  if (seen.position.z() > measured.z() + std::max(0.05, 2 * tolerance)) return;
  ++sum.counts.on_label;
  const float* plane = view.planes.planes.pixel(seen.pixel_u, seen.pixel_v);
  if (std::abs(distance) > tolerance ||
      seen.normal.dot(Eigen::Vector3d(plane[0], plane[1], plane[2])) < kNormalCosine) {
    return;
  }
  ++sum.counts.inliers;
  const double expected = texture.fused;
  if (std::isnan(expected) || view.mask.at(seen.pixel_u, seen.pixel_v) != MaskArea::kInterior) return;
  const double image = view.sample_texture(0, seen.u, seen.v).value;
  sum.sums[0] += expected;
  sum.sums[1] += image;
  sum.sums[2] += expected * expected;
  sum.sums[3] += image * image;
  sum.sums[4] += expected * image;
  sum.textured += 1;
}

} // namespace

void associate(const LayerModel& model, std::span<const PointTexture> textures, const LayerView& view,
               const motion::LayerPose& pose, int level, double gate, const DeformingAlignmentConfig& config,
               std::vector<DataTerm>& terms) {
  const AssociationGates gates{std::min(gate, config.plane_gate), gate, config.silhouette_weight};
  terms.resize(model.points.size());
  std::vector<float> image(model.points.size());
  parallel_for(model.points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    const std::size_t count = chunk.end - chunk.begin;
    associate_points(std::span(pose.points).subspan(chunk.begin, count), view, level, gates,
                     std::span(terms).subspan(chunk.begin, count), std::span(image).subspan(chunk.begin, count));
  });
  parallel_for(DataTerm::kTextures, 1,
               [&](const Chunk& which) { set_textures(textures, image, which.begin, level, config, terms); });
}

motion::NodeStates align_rigidly(const LayerModel& model, std::span<const PointTexture> textures, const LayerView& view,
                                 const motion::NodeStates& start, int level, double gate, int iterations,
                                 const DeformingAlignmentConfig& config) {
  constexpr int kTries = 6;
  DeformingProblem problem(model, view, weights_of(1, config));
  motion::LayerPose pose = motion::pose_layer(model.points, start);
  problem.set_level(level);
  for (int i = 0; i < iterations; ++i) {
    associate(model, textures, view, pose, level, gate, config, problem.terms());
    Matrix6d information;
    Twist gradient;
    const Eigen::Vector3d pivot = mean_position(pose.nodes);
    problem.linearise_rigid(pose, pivot, information, gradient);
    const double largest = information.diagonal().maxCoeff();
    if (!(largest > 0)) break;
    const double before = problem.energy(pose);
    MarquardtDamping damping({});
    const bool is_taken = damped_gauss_newton(damping, kTries, [&](double value) -> StepOutcome {
      Matrix6d levenberg_marquardt = information;
      levenberg_marquardt.diagonal() += (value * information.diagonal()).cwiseMax(1e-6 * largest);
      motion::LayerPose candidate = motion::pose_layer(
          model.points, rotated_about(pose.nodes, pivot, levenberg_marquardt.ldlt().solve(-gradient)));
      if (!(problem.energy(candidate) < before)) return {};
      pose = std::move(candidate);
      return {.is_taken = true, .is_last = true};
    });
    if (!is_taken) break;
  }
  return pose.nodes;
}

DeformingAlignment align_deforming(const LayerModel& model, std::span<const PointTexture> textures,
                                   const LayerView& view, const motion::NodeStates& start,
                                   const motion::NodeStates& prior, double spacing,
                                   const DeformingAlignmentConfig& config, std::span<const NodeTarget> binding) {
  DeformingAlignment result;
  DeformingProblem problem(model, view, weights_of(spacing, config));
  problem.set_prior(prior);
  motion::LayerPose pose = motion::pose_layer(
      model.points, config.rigid_iterations > 0 ? rigidly_aligned(model, textures, view, start, config) : start);
  NielsenDamping damping;
  const NodeShares shares(model);
  result.seen.assign(model.nodes.size(), 0);
  for (std::size_t s = 0; s < kLevels.size(); ++s) {
    problem.set_level(kLevels[s]);
    for (int i = 0; i < config.iterations[s]; ++i) {
      associate(model, textures, view, pose, kLevels[s], config.gates[s], config, problem.terms());
      const std::span<const DataTerm> terms = problem.terms();
      result.seen = shares.of([&](std::size_t p) { return terms[p].on_surface; });
      const auto observed =
          shares.of([&](std::size_t p) { return terms[p].on_surface || terms[p].violates_free_space; });
      problem.set_binding(downweighted(binding, observed));
      if (!take_step(problem, config, damping, pose, result.energies)) break;
      const std::size_t tries = result.energies.size();
      if (result.energies[tries - 1] > (1 - config.min_decrease) * result.energies[tries - 2]) break;
    }
  }
  result.nodes = std::move(pose.nodes);
  return result;
}

DeformingQuality evaluate_deformation(const LayerModel& model, std::span<const PointTexture> textures,
                                      const LayerView& view, const motion::NodeStates& states) {
  const motion::LayerPose pose = motion::pose_layer(model.points, states);
  std::vector<QualitySums> parts(chunk_count(model.points.size(), kPointsPerChunk));
  parallel_for(model.points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    for (std::size_t p = chunk.begin; p < chunk.end; ++p) {
      accumulate(project_point(pose.points[p], view), textures[p], view, parts[chunk.index]);
    }
  });
  QualitySums all;
  for (const QualitySums& part : parts) all.add(part);
  return all.quality();
}

} // namespace kinora::tracking
