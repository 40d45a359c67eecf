#include "tracking/rigid/constant_velocity.h"

#include <algorithm>

namespace kinora::tracking {

double steps_ahead(double earlier, double last, double next) {
  constexpr double kMaxSteps = 3;
  const double before = last - earlier;
  return before > 0 ? std::clamp((next - last) / before, 0.0, kMaxSteps) : 1.0;
}

SE3 extrapolated(const SE3& earlier, const SE3& last, const Eigen::Vector3d& pivot, double steps) {
  const Eigen::Vector3d now = last * pivot;
  Twist rotation = Twist::Zero();
  rotation.tail<3>() = steps * log_se3(last * earlier.inverse()).tail<3>();
  SE3 next = SE3::Identity();
  next.linear() = exp_se3(rotation).linear() * last.linear();
  next.translation() = now + steps * (now - earlier * pivot) - next.linear() * pivot;
  return renormalized(next);
}

} // namespace kinora::tracking
