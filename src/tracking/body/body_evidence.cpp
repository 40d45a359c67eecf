#include "tracking/body/body_evidence.h"

#include <algorithm>
#include <cmath>

#include "core/free_space.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kMinCosine = 0.2;
constexpr DepthMargin kMargin{0.01, 1.5};

// The silhouette is left: how far, and which way on the picture.
void silhouette_residual(const Vec& p, const std::int16_t* offset, const Intrinsics& camera, SampleResidual& r) {
  const Vec away(-offset[0] / camera.fx, -offset[1] / camera.fy, 0); // in the plane at distance 1
  const double size = away.norm();
  const Vec across(away.x() / size, away.y() / size, -(away.x() * p.x() + away.y() * p.y()) / (size * p.z()));
  r.visibility = Visibility::kFreeSpace;
  r.value = size * p.z();
  r.direction = across;
}

} // namespace

BodyEvidence gather_evidence(const LayerView& view, std::size_t max_points, const BodyEnergyConfig& config) {
  BodyEvidence evidence{&view, {}, observe_joints(view.joints, view.intrinsics, config.detected)};
  const double share = static_cast<double>(view.depth_pixels) / static_cast<double>(max_points);
  const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(share))));
  const double pixel = stride * stride / (view.intrinsics.fx * view.intrinsics.fy);
  for (int v = stride / 2; v < view.intrinsics.height; v += stride) {
    for (int u = stride / 2; u < view.intrinsics.width; u += stride) {
      if (view.planes.weights.at(u, v) <= 0) continue;
      const float* plane = view.planes.planes.pixel(u, v);
      const Vec position = view.point(u, v);
      evidence.points.push_back({position, Vec(plane[0], plane[1], plane[2]),
                                 pixel * position.z() * position.z() / (config.patch * config.patch)});
    }
  }
  return evidence;
}

BodyInCamera::BodyInCamera(const BodyState& state) : body_(pose_body(state.pose, state.shape)) {
  for (std::size_t i = 0; i < kBodyParts; ++i) {
    camera_to_bone_[i] = bone(i).inverse();
    centres_[i] = bone(i) * body_.parts[i].centre;
  }
}

void BodyInCamera::match(std::size_t part, const MeasuredPoint& point, double normal_length, Match& best) const {
  const PartShape& shape = body_.parts[part];
  const double farthest = shape.reach + best.root;
  if ((point.position - centres_[part]).squaredNorm() >= farthest * farthest) return;
  const ClosestSurface surface = closest_surface(shape, camera_to_bone_[part] * point.position);
  const double squared = surface.distance * surface.distance;
  if (squared >= best.cost) return;
  const double cosine = (bone(part).linear() * surface.normal).dot(point.normal);
  const double cost = squared + normal_length * normal_length * (1 - cosine);
  if (cosine < 0 || cost >= best.cost) return;
  best.cost = cost;
  best.root = std::sqrt(cost);
  best.surface = surface;
  best.part = static_cast<int>(part);
}

SampleResidual sample_residual(const BodyInCamera& body, const BodySample& sample, const LayerView& view,
                               const BodyEnergyConfig& config) {
  SampleResidual r;
  const PartShape& part = body.body().parts[sample.part];
  const SE3& bone = body.bone(sample.part);
  const Vec position = position_of(part, sample.point);
  const Vec outwards = gradient_of(part, sample.point);
  const Vec to_camera = body.to_bone(sample.part).translation() - position;
  const double facing = outwards.dot(to_camera);
  if (facing <= 0) return r;
  const double cosine = facing / std::sqrt(outwards.squaredNorm() * to_camera.squaredNorm());
  if (cosine < kMinCosine) return r;
  const Vec p = bone * position;
  if (p.z() < 0.1) return r;
  const Eigen::Vector2d pixel = view.intrinsics.project(p);
  const int u = static_cast<int>(std::lround(std::clamp(pixel.x(), -1.0, 1e6)));
  const int v = static_cast<int>(std::lround(std::clamp(pixel.y(), -1.0, 1e6)));
  if (!view.mask.contains(u, v)) return r;
  r.weight = sample.area * (cosine - kMinCosine) / (config.patch * config.patch);
  const double measured = view.depth.at(u, v);
  if (is_occluded(p.z(), measured, kMargin)) {
    r.visibility = Visibility::kHidden;
    return r;
  }
  const std::int16_t* offset = view.to_silhouette.pixel(u, v);
  if (offset[0] != 0 || offset[1] != 0) {
    silhouette_residual(p, offset, view.intrinsics, r);
  } else if (violates_free_space(p.z(), measured, kMargin)) {
    r.visibility = Visibility::kFreeSpace; // and must go back along the ray
    r.value = (measured - kMargin.at(p.z()) - p.z()) / p.z() * p.norm();
    r.direction = -p / p.norm();
  } else {
    r.visibility = view.mask.at(u, v) != 0 ? Visibility::kSeen : Visibility::kHidden;
  }
  return r;
}

} // namespace kinora::tracking
