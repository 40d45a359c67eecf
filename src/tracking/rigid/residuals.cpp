#include "tracking/rigid/residuals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/statistics.h"

namespace kinora::tracking {
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

TextureModel measure_texture(std::span<const ModelPoint> points, const LayerView& view, const SE3& model_to_camera,
                             int level) {
  TextureModel model;
  std::array<std::vector<double>, ModelPoint::kDirections> differences;
  for (const ModelPoint& point : points) {
    const auto projected = project(point, view, model_to_camera);
    if (!projected) continue;
    const auto r = photometric_residual(*projected, point, view, Pivot(), level);
    if (r) differences[point.direction].push_back(r->value);
  }
  std::vector<double> sizes;
  for (std::size_t i = 0; i < differences.size(); ++i) {
    if (differences[i].empty()) continue;
    model.light[i] = median(differences[i]);
    for (const double difference : differences[i]) sizes.push_back(std::abs(difference - model.light[i]));
  }
  if (!sizes.empty()) model.sigma = std::max(TextureModel::kMinTextureSigma, kDeviationPerMedian * median(sizes));
  return model;
}

} // namespace kinora::tracking
