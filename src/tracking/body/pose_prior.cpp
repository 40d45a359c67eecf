#include "tracking/body/pose_prior.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace kinora::tracking {
namespace {

using Matrix = Eigen::Matrix<double, kLimbAngles, kLimbAngles>;

constexpr std::size_t kFitted = 4;
constexpr std::size_t kComponents = kFitted + 1; // the last: any way

// A Gaussian of left limbs: its share, mean, and covariance row by row, up to the diagonal.
struct Row {
  double share;
  std::array<double, 4> mean;
  std::array<double, 10> covariance;
};

constexpr std::array<Row, kFitted> kArms = {{
    {0.697,
     {0.047, 0.034, -1.425, 1.024},
     {0.1076, -0.0305, 0.1689, 0.0031, -0.0007, 0.0327, 0.0793, -0.1147, 0.0154, 0.2928}},
    {0.195,
     {-0.612, -0.924, -0.865, 0.832},
     {0.2339, -0.1344, 0.4116, -0.0687, 0.0213, 0.2455, 0.0569, 0.0097, 0.0106, 0.1165}},
    {0.089,
     {-0.238, -0.736, -0.951, 1.677},
     {0.2090, 0.0095, 0.2402, -0.0315, -0.0973, 0.1280, 0.0385, 0.0049, -0.0202, 0.1398}},
    {0.020,
     {-0.341, 0.240, -0.078, 0.477},
     {0.0301, 0.0240, 0.3992, 0.0084, -0.0693, 0.0580, -0.0018, -0.0576, 0.0122, 0.0382}},
}};
constexpr std::array<Row, kFitted> kLegs = {{
    {0.787,
     {-0.191, -0.011, -0.010, 0.589},
     {0.1131, 0.0028, 0.0429, -0.0059, 0.0047, 0.0276, -0.0477, 0.0048, 0.0036, 0.0786}},
    {0.184,
     {-0.856, 0.092, 0.039, 1.471},
     {0.2739, 0.0011, 0.0457, 0.0068, 0.0112, 0.0509, -0.0362, 0.0052, 0.0165, 0.1082}},
    {0.019,
     {-0.709, 0.484, 0.012, 1.132},
     {0.0802, 0.0270, 0.0632, 0.0050, -0.0007, 0.0987, -0.0349, -0.0110, 0.0074, 0.0652}},
    {0.010,
     {-1.470, -0.170, 0.368, 0.939},
     {0.1679, -0.0633, 0.0594, 0.0349, -0.0224, 0.0355, 0.0245, -0.0378, 0.0139, 0.0755}},
}};

struct Gaussian {
  double height; ///< density at the mean, but for a factor that all have
  LimbAngles mean;
  Matrix precision;
};

Gaussian gaussian(double share, const LimbAngles& mean, const Matrix& covariance) {
  return {share / std::sqrt(covariance.determinant()), mean, covariance.inverse()};
}

Gaussian from_row(const Row& row) {
  Matrix covariance;
  std::size_t next = 0;
  for (Eigen::Index i = 0; i < kLimbAngles; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) covariance(i, j) = covariance(j, i) = row.covariance.at(next++);
  }
  return gaussian(row.share, Eigen::Map<const LimbAngles>(row.mean.data()), covariance);
}

// The joints' usual angles, each by itself.
Gaussian wide_gaussian(Limb left) {
  const JointInfo& ball = joints()[chain_of(left).ball];
  const JointInfo& hinge = joints()[chain_of(left).hinge];
  LimbAngles mean;
  LimbAngles sigma;
  mean << ball.usual, hinge.usual[0];
  sigma << ball.sigma, hinge.sigma[0];
  return gaussian(1, mean, sigma.cwiseAbs2().asDiagonal());
}

using Mixture = std::array<Gaussian, kComponents>;

Mixture build(Limb left, const std::array<Row, kFitted>& rows) {
  Mixture mixture;
  for (std::size_t i = 0; i < kFitted; ++i) mixture[i] = from_row(rows[i]);
  mixture[kFitted] = wide_gaussian(left);
  return mixture;
}

const Mixture& mixture_of(Limb limb) {
  static const Mixture arms = build(kLeftArm, kArms);
  static const Mixture legs = build(kLeftLeg, kLegs);
  return limb == kLeftArm || limb == kRightArm ? arms : legs;
}

// What makes a right limb's rotation vector a left one's, and back.
LimbAngles mirror_of(Limb limb) {
  const bool right = limb == kRightArm || limb == kRightLeg;
  return right ? LimbAngles(1, -1, -1, 1) : LimbAngles(1, 1, 1, 1);
}

} // namespace

LimbAngles limb_angles(Limb limb, const Angles& angles) {
  LimbAngles result;
  result << angles.segment<3>(joints()[chain_of(limb).ball].first_angle),
      angles[joints()[chain_of(limb).hinge].first_angle];
  return result;
}

PosePrior pose_prior(Limb limb, const LimbAngles& angles, const PosePriorConfig& config) {
  const auto trust_in = [&config](std::size_t part) { return part < kFitted ? config.trust : 1 - config.trust; };
  const LimbAngles mirror = mirror_of(limb);
  const LimbAngles left = mirror.cwiseProduct(angles);
  const Mixture& mixture = mixture_of(limb);
  std::array<double, kComponents> squares;
  double nearest = 1e300;
  for (std::size_t i = 0; i < kComponents; ++i) {
    const LimbAngles away = left - mixture[i].mean;
    squares[i] = away.dot(mixture[i].precision * away);
    if (trust_in(i) > 0) nearest = std::min(nearest, squares[i]);
  }
  // Densities at the pose, but for exp(−nearest / 2), which would vanish far away.
  std::array<double, kComponents> densities;
  double highest = 0;
  double density = 0;
  for (std::size_t i = 0; i < kComponents; ++i) {
    const double height = trust_in(i) * mixture[i].height;
    densities[i] = height > 0 ? height * std::exp(-0.5 * (squares[i] - nearest)) : 0.0;
    highest += height;
    density += densities[i];
  }
  PosePrior prior{config.weight * (nearest - 2 * std::log(density / highest)), LimbAngles::Zero(), Matrix::Zero()};
  for (std::size_t i = 0; i < kComponents; ++i) {
    const Matrix weighted_precision = config.weight * densities[i] / density * mixture[i].precision;
    prior.gradient += weighted_precision * (left - mixture[i].mean);
    prior.hessian += weighted_precision;
  }
  prior.gradient = mirror.cwiseProduct(prior.gradient);
  prior.hessian = mirror.asDiagonal() * prior.hessian * mirror.asDiagonal();
  return prior;
}

} // namespace kinora::tracking
