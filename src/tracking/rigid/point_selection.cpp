#include "tracking/rigid/point_selection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tracking/view/visibility.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kDirections = ModelPoint::kDirections;
constexpr auto kFacing = static_cast<float>(kFacingCosine);
constexpr auto kNearest = static_cast<float>(kNearestDepth);
constexpr int kCell = 4; // pixels; a few of the model's points fall into each cell

struct FloatPose {
  Eigen::Matrix3f rotation;
  Eigen::Vector3f translation;
  explicit FloatPose(const SE3& pose)
      : rotation(pose.linear().cast<float>()), translation(pose.translation().cast<float>()) {}
};

// Pixel coordinates, or negative ones if the point faces away or lies outside.
Eigen::Vector2f visible_pixel(const SurfacePoint& surface, const FloatPose& pose, const Intrinsics& camera, float& z) {
  const Eigen::Vector3f p = pose.rotation * surface.position + pose.translation;
  const Eigen::Vector3f n = pose.rotation * surface.normal;
  Eigen::Vector2f nowhere(-1, -1);
  z = p.z();
  const float facing = n.dot(p);
  const bool faces_away = !(facing < 0) || facing * facing < kFacing * kFacing * p.squaredNorm();
  if (p.z() < kNearest || faces_away) return nowhere;
  const float u = static_cast<float>(camera.fx) * p.x() / p.z() + static_cast<float>(camera.cx);
  const float v = static_cast<float>(camera.fy) * p.y() / p.z() + static_cast<float>(camera.cy);
  if (!(u >= 0 && v >= 0 && u <= static_cast<float>(camera.width - 1) && v <= static_cast<float>(camera.height - 1))) {
    return nowhere;
  }
  return {u, v};
}

// The largest number that may be drawn from each bin such that at most `limit` are drawn in all.
std::size_t normal_space_quota(const std::array<std::vector<std::size_t>, kDirections>& bins, std::size_t limit) {
  std::size_t low = 0;
  std::size_t high = limit;
  while (low < high) {
    const std::size_t middle = (low + high + 1) / 2;
    std::size_t drawn = 0;
    for (const auto& bin : bins) drawn += std::min(bin.size(), middle);
    if (drawn <= limit) {
      low = middle;
    } else {
      high = middle - 1;
    }
  }
  return low;
}

} // namespace

std::vector<ModelPoint> select_points(std::span<const SurfacePoint> surface, const LayerView& view,
                                      const SE3& model_to_camera, std::size_t max_points) {
  const FloatPose pose(model_to_camera);
  std::array<std::vector<std::size_t>, kDirections> bins;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    float z = 0;
    if (visible_pixel(surface[i], pose, view.intrinsics, z).x() >= 0)
      bins[direction_of(surface[i].normal)].push_back(i);
  }
  const std::size_t quota = normal_space_quota(bins, max_points);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  std::vector<ModelPoint> points;
  for (const std::vector<std::size_t>& bin : bins) {
    const std::size_t count = std::min(bin.size(), quota);
    for (std::size_t k = 0; k < count; ++k) {
      const SurfacePoint& chosen = surface[bin[k * bin.size() / count]];
      points.push_back({chosen.position, chosen.normal, {chosen.intensity, kNone, kNone}, direction_of(chosen.normal)});
    }
  }
  return points;
}

void add_coarse_texture(const LayerView& view, const SE3& model_to_camera, ModelPoint& point) {
  // The residual against a texture of zero is the image's own texture, with every test of visibility made.
  ModelPoint probe = point;
  probe.texture.fill(0.0F);
  const auto projected = project(probe, view, model_to_camera);
  if (!projected) return;
  for (int level = 1; level < LayerView::kLevels; ++level) {
    const auto seen = photometric_residual(*projected, probe, view, Pivot(), level);
    if (seen) point.texture[static_cast<std::size_t>(level)] = static_cast<float>(seen->value);
  }
}

void remove_occluders(std::span<const SurfacePoint> surface, const SE3& model_to_camera, const LayerView& view,
                      DepthPlanes& planes) {
  const FloatPose pose(model_to_camera);
  DepthImage nearest((view.intrinsics.width + kCell - 1) / kCell, (view.intrinsics.height + kCell - 1) / kCell);
  for (const SurfacePoint& point : surface) {
    float z = 0;
    const Eigen::Vector2f pixel = visible_pixel(point, pose, view.intrinsics, z);
    if (pixel.x() < 0) continue;
    float& cell = nearest.at(static_cast<int>(pixel.x()) / kCell, static_cast<int>(pixel.y()) / kCell);
    if (cell == 0 || z < cell) cell = z;
  }
  for (int v = 0; v < view.intrinsics.height; ++v) {
    for (int u = 0; u < view.intrinsics.width; ++u) {
      const float model = nearest.at(u / kCell, v / kCell);
      if (model == 0 || planes.weights.at(u, v) <= 0) continue;
      if (is_occluded(model, view.point(u, v).z(), kPoseMargin)) planes.weights.at(u, v) = 0;
    }
  }
}

} // namespace kinora::tracking
