#include "tracking/body/body_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>

#include "core/statistics.h"
#include "tracking/body/limb_search.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr std::size_t kCoarsePoints = 400;
constexpr std::size_t kFinePoints = 1500;
constexpr int kSides = 8;
constexpr std::size_t kMaxHypotheses = 4; // hypotheses whose limbs are searched for
constexpr double kDepthToMiddle = 0.08;   // metres from the surface that is seen

// Which way the person stands: the long axis of what is seen, if there is one and it is not far from the camera's.
Vec find_up_axis(const BodyEvidence& evidence) {
  constexpr double kElongated = 3; // squares of the axes
  constexpr double kUpright = 0.7; // cosine
  const Vec usual(0, -1, 0);
  Vec mean = Vec::Zero();
  double weight = 0;
  for (const MeasuredPoint& p : evidence.points) {
    mean += p.weight * p.position;
    weight += p.weight;
  }
  mean /= weight;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const MeasuredPoint& p : evidence.points) {
    covariance += p.weight * (p.position - mean) * (p.position - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  Vec axis = solver.eigenvectors().col(2);
  if (axis.dot(usual) < 0) axis = -axis;
  const bool clear = solver.eigenvalues()[2] > kElongated * solver.eigenvalues()[1] && axis.dot(usual) > kUpright;
  return clear ? axis : usual;
}

struct Extent {
  Vec up;
  double top, bottom; ///< along it, metres from the camera
  Vec middle;         ///< of the trunk
};

Extent find_extent(const BodyEvidence& evidence) {
  Extent extent{find_up_axis(evidence), 0, 0, Vec::Zero()};
  std::vector<double> heights;
  std::array<std::vector<double>, 3> coordinates;
  for (const MeasuredPoint& p : evidence.points) {
    heights.push_back(p.position.dot(extent.up));
    for (std::size_t i = 0; i < 3; ++i) coordinates[i].push_back(p.position[static_cast<Eigen::Index>(i)]);
  }
  extent.top = *std::max_element(heights.begin(), heights.end());
  extent.bottom = *std::min_element(heights.begin(), heights.end());
  for (std::size_t i = 0; i < 3; ++i) extent.middle[static_cast<Eigen::Index>(i)] = median(coordinates[i]);
  return extent;
}

BodyState initial_state(const Extent& extent, double height, double yaw) {
  constexpr double kPelvisHeight = 0.532; // of the body's height
  const Vec away = (extent.middle - extent.middle.dot(extent.up) * extent.up).normalized();
  const Vec side = extent.up.cross(-away);
  const Vec forward = -std::cos(yaw) * away + std::sin(yaw) * side;
  BodyState state{rest_pose(), Shape::Zero()};
  state.shape[kHeight] = std::log(height / kMeanHeight);
  state.pose.root.linear() << extent.up.cross(forward), extent.up, forward;
  const Vec axis = extent.middle - extent.middle.dot(extent.up) * extent.up + kDepthToMiddle * away;
  state.pose.root.translation() = axis + (extent.top - (1 - kPelvisHeight) * height) * extent.up;
  return state;
}

BodyEnergyConfig relaxed(BodyEnergyConfig config) {
  config.cutoff *= 3;
  config.detected.cutoff *= 3;
  return config;
}

BodyFit fitted_coarsely(BodyState state, const BodyEvidence& evidence, const BodyPrior& prior,
                        const BodyEnergyConfig& config) {
  minimise(evidence, prior, relaxed(config), 8, false, state);
  const double energy = minimise(evidence, prior, config, 8, true, state);
  return {state, energy};
}

// The few that explain the view best as they are.
std::vector<BodyPose> best_poses(std::span<const BodyPose> poses, const BodyEvidence& evidence, const BodyPrior& prior,
                                 const BodyEnergyConfig& config) {
  constexpr std::size_t kTried = 4;
  std::vector<BodyFit> fits;
  for (const BodyPose& pose : poses) {
    const BodyState state{pose, prior.state.shape};
    fits.push_back({state, evaluate(evidence, state, prior, relaxed(config)).energy});
  }
  std::stable_sort(fits.begin(), fits.end(), [](const BodyFit& a, const BodyFit& b) { return a.energy < b.energy; });
  std::vector<BodyPose> best;
  for (std::size_t i = 0; i < std::min(kTried, fits.size()); ++i) best.push_back(fits[i].state.pose);
  return best;
}

// The best, but few of each side that is shown to the camera: somebody's back may look like a front until limbs are
// searched for, and most starts may lead to one of the two.
std::vector<BodyFit> best_of_each_side(std::vector<BodyFit> fits) {
  constexpr double kSameSide = std::numbers::pi / 3;
  constexpr int kPerSide = 2;
  std::stable_sort(fits.begin(), fits.end(), [](const BodyFit& a, const BodyFit& b) { return a.energy < b.energy; });
  std::vector<BodyFit> best;
  for (const BodyFit& fit : fits) {
    const auto shows_same = [&fit](const BodyFit& other) {
      const Eigen::Quaterniond yaw(other.state.pose.root.linear());
      return yaw.angularDistance(Eigen::Quaterniond(fit.state.pose.root.linear())) < kSameSide;
    };
    if (best.size() < kMaxHypotheses && std::count_if(best.begin(), best.end(), shows_same) < kPerSide)
      best.push_back(fit);
  }
  return best;
}

// `coarse` and `fine`: of one view.
BodyFit fit_to(const BodyEvidence& coarse, const BodyEvidence& fine, const BodyPrior& prior,
               const BodyEnergyConfig& config, std::span<const BodyPose> earlier) {
  constexpr double kMinHeight = 1.0;
  const Extent extent = find_extent(fine);
  const double usual = kMeanHeight * std::exp(prior.state.shape[kHeight]);
  std::vector<BodyFit> fits;
  for (const double height : {extent.top - extent.bottom, usual}) {
    if (height < kMinHeight) continue;
    for (int i = 0; i < kSides; ++i) {
      fits.push_back(
          fitted_coarsely(initial_state(extent, height, 2 * std::numbers::pi * i / kSides), coarse, prior, config));
    }
  }
  for (const BodyPose& pose : best_poses(earlier, coarse, prior, config)) {
    fits.push_back(fitted_coarsely({pose, prior.state.shape}, coarse, prior, config));
  }
  fits = best_of_each_side(std::move(fits));
  for (BodyFit& fit : fits) {
    for (const Limb limb : kEveryLimb) search_limb(limb, coarse, prior, config, 0, 0, fit.state);
    fit.energy = minimise(fine, prior, config, 20, true, fit.state);
  }
  return *std::min_element(fits.begin(), fits.end(),
                           [](const BodyFit& a, const BodyFit& b) { return a.energy < b.energy; });
}

} // namespace

BodyFit fit_body(const LayerView& view, const BodyPrior& prior, const BodyEnergyConfig& config,
                 std::span<const BodyPose> earlier) {
  constexpr double kDoubt = 15; // energy of the view: what differs by less, detected joints decide
  BodyEvidence coarse = gather_evidence(view, kCoarsePoints, config);
  BodyEvidence fine = gather_evidence(view, kFinePoints, config);
  std::optional<BodyFit> detected;
  if (!fine.joints.empty()) {
    detected = fit_to(coarse, fine, prior, config, earlier);
    coarse.joints.clear();
    fine.joints.clear();
    detected->energy = evaluate(fine, detected->state, prior, config).energy;
  }
  const BodyFit seen = fit_to(coarse, fine, prior, config, earlier);
  return detected && detected->energy < seen.energy + kDoubt ? *detected : seen;
}

} // namespace kinora::tracking
