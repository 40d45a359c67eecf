#include "encode/motion_smoothing.h"

#include <algorithm>
#include <span>
#include <utility>

#include <Eigen/Cholesky>

#include "encode/node_correction.h"

namespace kinora::encode {
namespace {

constexpr std::size_t kReach = 4;
constexpr std::size_t kWindow = 2 * kReach + 1;
constexpr double kTrackerSigma = 0.005; // metres

using Deformations = std::span<const motion::Motion::Deformation>;

/// What each of the window's numbers counts in the value that the parabola nearest to them has at the number `at`.
Eigen::RowVectorXd parabola_weights(std::size_t at) {
  const Eigen::ArrayXd time =
      Eigen::ArrayXd::LinSpaced(static_cast<Eigen::Index>(kWindow), 0, static_cast<double>(kWindow - 1)) -
      static_cast<double>(at);
  Eigen::MatrixX3d powers(time.size(), 3);
  powers << Eigen::ArrayXd::Ones(time.size()), time, time.square();
  return (powers.transpose() * powers).ldlt().solve(powers.transpose()).row(0);
}

/// Where the tracked frames around the tracked frame `f` begin and end (one behind the last), no farther than a window.
std::pair<std::size_t, std::size_t> tracked_around(Deformations frames, std::size_t f) {
  const auto is_tracked = [&](std::size_t i) { return frames[i].health == motion::Health::kTracked; };
  std::size_t begin = f;
  while (begin > 0 && f - begin < kWindow && is_tracked(begin - 1)) --begin;
  std::size_t end = f + 1;
  while (end < frames.size() && end - f < kWindow && is_tracked(end)) ++end;
  return {begin, end};
}

DualQuaternion smoothed(Deformations window, std::size_t at, const Eigen::RowVectorXd& weights, std::size_t n,
                        const Eigen::Vector3d& place) {
  const DualQuaternion& node = window[at].node_to_world[n];
  Twist correction = Twist::Zero();
  for (std::size_t k = 0; k < window.size(); ++k) {
    if (k == at) continue;
    correction += weights[static_cast<Eigen::Index>(k)] * correction_of(place, node, window[k].node_to_world[n]);
  }
  const double off = correction.head<3>().norm() / kTrackerSigma;
  return corrected(place, node, correction / (1 + off * off));
}

} // namespace

motion::Motion smoothed_in_time(const motion::Motion& motion) {
  const std::vector<Eigen::Vector3d>& nodes = motion.graph()->nodes();
  const Deformations rough = motion.deformations();
  std::vector<motion::Motion::Deformation> smooth = motion.deformations();
  for (std::size_t f = 0; f < rough.size(); ++f) {
    if (rough[f].health != motion::Health::kTracked) continue;
    const auto [begin, end] = tracked_around(rough, f);
    if (end - begin < kWindow) continue;
    const std::size_t first = std::clamp(f, begin + kReach, end - kReach - 1) - kReach;
    const Deformations window = rough.subspan(first, kWindow);
    const Eigen::RowVectorXd weights = parabola_weights(f - first);
    for (std::size_t n = 0; n < nodes.size(); ++n)
      smooth[f].node_to_world[n] = smoothed(window, f - first, weights, n, nodes[n]);
  }
  return motion::Motion::deforming(motion.graph(), std::move(smooth));
}

} // namespace kinora::encode
