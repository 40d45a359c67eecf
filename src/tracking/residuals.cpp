#include "tracking/residuals.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ingest/sensor_noise.h"
#include "tracking/statistics.h"

namespace kinora::tracking {
namespace {

constexpr double kFacingCosine = 0.17; // 80°

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

std::optional<ProjectedPoint> project(const ModelPoint& model, const ObjectView& view, const SE3& model_to_camera) {
  ProjectedPoint p;
  p.point = model_to_camera * model.position.cast<double>();
  p.normal = model_to_camera.linear() * model.normal.cast<double>();
  if (p.point.z() < 0.05 || p.normal.dot(p.point) > -kFacingCosine * p.point.norm()) return std::nullopt;
  p.u = view.intrinsics.fx * p.point.x() / p.point.z() + view.intrinsics.cx;
  p.v = view.intrinsics.fy * p.point.y() / p.point.z() + view.intrinsics.cy;
  if (!(p.u > -0.49 && p.v > -0.49 && p.u < view.intrinsics.width - 0.51 && p.v < view.intrinsics.height - 0.51)) {
    return std::nullopt;
  }
  p.pixel_u = static_cast<int>(std::lround(p.u));
  p.pixel_v = static_cast<int>(std::lround(p.v));
  return p;
}

std::optional<Residual> geometric_residual(const ProjectedPoint& p, const ObjectView& view, const Pivot& pivot,
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

std::optional<Residual> photometric_residual(const ProjectedPoint& p, const ModelPoint& model, const ObjectView& view,
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

TextureModel measure_texture(std::span<const ModelPoint> points, const ObjectView& view, const SE3& model_to_camera,
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
  if (!sizes.empty()) model.sigma = std::max(TextureModel::kMinTextureSigma, 1.4826 * median(sizes));
  return model;
}

} // namespace kinora::tracking
