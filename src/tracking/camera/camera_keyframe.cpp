#include "tracking/camera/camera_keyframe.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/sensor_noise.h"
#include "core/statistics.h"
#include "tracking/rigid/point_selection.h"
#include "tracking/view/visibility.h"

namespace kinora::tracking {
namespace {

constexpr int kCell = 4;                          // pixels
constexpr int kStride = 2;                        // pixels between those that directions are drawn from
constexpr std::size_t kNormalSpaceSamples = 1000; // points over the directions of the normal
constexpr std::size_t kMinInliers = 150;
constexpr double kMinInlierShare = 0.5;
constexpr double kMinCorrelation = 0.5;
constexpr double kDegenerateShare = 0.002; // means of blocks have steadier normals than an object's single pixels
constexpr double kTextureTolerance = 0.01; // metres; a hand's motion is not foretold better
constexpr double kUnseenCost = 0.1;        // about what a point costs that is where it should be
constexpr double kCertainShare = 0.75;

ModelPoint point_at(const LayerView& view, int u, int v) {
  const float* plane = view.planes.planes.pixel(u, v);
  ModelPoint point{view.point(u, v).cast<float>(), {plane[0], plane[1], plane[2]}, {}, 0};
  point.direction = direction_of(point.normal);
  for (int level = 0; level < LayerView::kLevels; ++level) {
    point.texture[static_cast<std::size_t>(level)] = view.mask.at(u, v) == MaskArea::kInterior
                                                         ? view.sample_texture(level, u, v).value
                                                         : std::numeric_limits<float>::quiet_NaN();
  }
  return point;
}

void add_high_gradient_points(const LayerView& view, std::vector<ModelPoint>& points) {
  for (int top = 0; top < view.intrinsics.height; top += kCell) {
    for (int left = 0; left < view.intrinsics.width; left += kCell) {
      float strongest = -1;
      int best_u = 0;
      int best_v = 0;
      for (int v = top; v < std::min(top + kCell, view.intrinsics.height); ++v) {
        for (int u = left; u < std::min(left + kCell, view.intrinsics.width); ++u) {
          if (view.planes.weights.at(u, v) <= 0) continue;
          const TextureSample texture = view.sample_texture(0, u, v);
          const float strength =
              view.mask.at(u, v) == MaskArea::kInterior ? texture.du * texture.du + texture.dv * texture.dv : 0.0F;
          if (strength <= strongest) continue;
          strongest = strength;
          best_u = u;
          best_v = v;
        }
      }
      if (strongest >= 0) points.push_back(point_at(view, best_u, best_v));
    }
  }
}

void add_normal_space_samples(const LayerView& view, std::vector<ModelPoint>& points) {
  std::vector<SurfacePoint> surface;
  for (int v = 0; v < view.intrinsics.height; v += kStride) {
    for (int u = 0; u < view.intrinsics.width; u += kStride) {
      if (view.planes.weights.at(u, v) <= 0) continue;
      const ModelPoint point = point_at(view, u, v);
      surface.push_back({point.position, point.normal, point.texture[0], 1});
    }
  }
  for (const ModelPoint& chosen : select_points(surface, view, SE3::Identity(), kNormalSpaceSamples)) {
    const Eigen::Vector2d pixel = view.intrinsics.project(chosen.position.cast<double>());
    points.push_back(
        point_at(view, static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))));
  }
}

// Whether their texture varies by more than alignment takes for noise.
bool have_texture(std::span<const ModelPoint> points) {
  double count = 0;
  double sum = 0;
  double squares = 0;
  for (const ModelPoint& point : points) {
    if (std::isnan(point.texture[0])) continue;
    count += 1;
    sum += point.texture[0];
    squares += point.texture[0] * point.texture[0];
  }
  constexpr double kFloor = TextureModel::kMinTextureSigma * TextureModel::kMinTextureSigma;
  return count > 0 && squares / count - sum * sum / (count * count) >= kFloor;
}

} // namespace

CameraKeyframe make_keyframe(const BackgroundFrame& reduced, const LayerView& view) {
  CameraKeyframe keyframe{reduced, {}, 1, {}};
  add_high_gradient_points(view, keyframe.points);
  add_normal_space_samples(view, keyframe.points);
  std::vector<double> depths;
  for (const ModelPoint& point : keyframe.points) depths.push_back(point.position.z());
  if (!depths.empty()) keyframe.distance = median(depths);
  return keyframe;
}

bool CameraFit::supported() const {
  return quality.inliers >= kMinInliers && quality.inlier_share() >= kMinInlierShare &&
         alignment.degenerate_directions < 6;
}

bool CameraFit::certain() const { return complete() && quality.inlier_share() >= kCertainShare; }

CameraFit fit_camera(std::span<const ModelPoint> points, const LayerView& view, const SE3& expected,
                     int coarsest_level) {
  std::vector<ModelPoint> visible;
  if (!view.empty()) {
    for (const ModelPoint& point : points) {
      if (project(point, view, expected)) visible.push_back(point);
    }
  }
  CameraFit fit;
  AlignmentConfig config;
  config.coarsest_level = coarsest_level;
  config.degenerate_share = kDegenerateShare;
  config.texture_tolerance = kTextureTolerance;
  config.unseen_cost = kUnseenCost;
  fit.alignment = align(visible, view, expected, expected, {}, config);
  fit.quality = evaluate_pose(visible, view, fit.pose());
  if (have_texture(visible) && fit.quality.texture_correlation < kMinCorrelation) {
    config.photometric_weight = 0;
    fit.dark = true;
    fit.alignment = align(visible, view, expected, expected, {}, config);
    fit.quality = evaluate_pose(visible, view, fit.pose());
  }
  return fit;
}

double view_change(const SE3& motion, double distance) {
  return rotation_angle(motion) + motion.translation().norm() / distance;
}

double visible_shift(std::span<const ModelPoint> points, const Intrinsics& intrinsics, const SE3& motion) {
  double squares = 0;
  double count = 0;
  for (const ModelPoint& point : points) {
    const Eigen::Vector3d before = point.position.cast<double>();
    const Eigen::Vector3d after = motion * before;
    if (before.z() < kNearestDepth || after.z() < kNearestDepth) continue;
    const double noise = (after.z() - before.z()) / kSensorNoise.sigma(before.z());
    squares += (intrinsics.project(after) - intrinsics.project(before)).squaredNorm() + noise * noise;
    count += 1;
  }
  return count > 0 ? std::sqrt(squares / count) : 0.0;
}

std::optional<SE3> relative_pose(const CameraKeyframe& a, const CameraKeyframe& b, const LayerView& b_view,
                                 const SE3& b_to_a) {
  const CameraFit there = fit_camera(b.points, view_background(a.frame), b_to_a);
  if (!there.complete()) return std::nullopt;
  const CameraFit back = fit_camera(a.points, b_view, there.pose().inverse());
  if (!back.complete()) return std::nullopt;
  if (visible_shift(b.points, b.frame.intrinsics, back.pose() * there.pose()) > 1) return std::nullopt;
  return interpolate(there.pose(), back.pose().inverse(), 0.5);
}

} // namespace kinora::tracking
