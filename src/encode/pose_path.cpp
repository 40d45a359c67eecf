#include "encode/pose_path.h"

#include <algorithm>

namespace kinora::encode {
namespace {

std::vector<double> lagrange_weights(std::span<const double> times, std::span<const std::size_t> frames, double time) {
  std::vector<double> weights;
  for (const std::size_t i : frames) {
    double weight = 1;
    for (const std::size_t k : frames) {
      if (k != i) weight *= (time - times[k]) / (times[i] - times[k]);
    }
    weights.push_back(weight);
  }
  return weights;
}

} // namespace

PathSupport path_support(std::span<const double> times, double time,
                         const std::function<bool(std::size_t frame)>& tracked) {
  const auto after = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  PathSupport support;
  const auto use = [&](std::size_t frame) { support.frames.push_back(frame); };
  if (after > 0) use(after - 1);
  if (after < times.size()) use(after);
  if (std::all_of(support.frames.begin(), support.frames.end(), tracked)) {
    if (after > 1 && tracked(after - 2)) use(after - 2);
    if (after + 1 < times.size() && tracked(after + 1)) use(after + 1);
  }
  support.weights = lagrange_weights(times, support.frames, time);
  return support;
}

SE3 pose_on_path(std::span<const SE3> poses, std::span<const double> weights) {
  const SE3& base = poses.front();
  Twist sum = Twist::Zero();
  for (std::size_t i = 1; i < poses.size(); ++i) sum += weights[i] * log_se3(base.inverse() * poses[i]);
  return renormalized(base * exp_se3(sum));
}

} // namespace kinora::encode
