#include "encode/motion_smoothing.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "encode/node_correction.h"

namespace kinora::encode {

motion::Motion smoothed_in_time(const motion::Motion& motion) {
  constexpr std::size_t kReach = 3;
  constexpr std::array<double, 2 * kReach + 1> kParabola{-2.0 / 21, 3.0 / 21, 6.0 / 21, 7.0 / 21,
                                                         6.0 / 21,  3.0 / 21, -2.0 / 21};
  constexpr double kTrackerSigma = 0.005; // metres
  const std::vector<Eigen::Vector3d>& nodes = motion.graph()->nodes();
  const std::vector<motion::Motion::Deformation>& rough = motion.deformations();
  std::vector<motion::Motion::Deformation> smooth = rough;
  for (std::size_t f = kReach; f + kReach < rough.size(); ++f) {
    const auto window = std::span(rough).subspan(f - kReach, kParabola.size());
    const auto is_tracked = [](const motion::Motion::Deformation& d) { return d.health == motion::Health::kTracked; };
    if (!std::all_of(window.begin(), window.end(), is_tracked)) continue;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const DualQuaternion& node = rough[f].node_to_world[n];
      Twist correction = Twist::Zero();
      for (std::size_t k = 0; k < window.size(); ++k) {
        if (k != kReach) correction += kParabola[k] * correction_of(nodes[n], node, window[k].node_to_world[n]);
      }
      const double off = correction.head<3>().norm() / kTrackerSigma;
      smooth[f].node_to_world[n] = corrected(nodes[n], node, correction / (1 + off * off));
    }
  }
  return motion::Motion::deforming(motion.graph(), std::move(smooth));
}

} // namespace kinora::encode
