// What one point of a rigid model says about its pose in one view: a distance along its normal, and a texture.
// Sources: Chen and Medioni, "Object modelling by registration of multiple range images", 1992 (point to plane);
// Baker and Matthews, "Lucas-Kanade 20 Years On", IJCV 2004 (texture).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "core/se3.h"
#include "core/sensor_noise.h"
#include "tracking/view/layer_view.h"
#include "tracking/view/visibility.h"

namespace kinora::tracking {

/// A point of the model's surface, in the model's own coordinates (metres, near its origin).
struct ModelPoint {
  Eigen::Vector3f position;
  Eigen::Vector3f normal; ///< unit, out of the surface
  /// Texture expected at each level of LayerView::pyramid; NaN where none is.
  std::array<float, LayerView::kLevels> texture;
  /// Which way the normal points, below kDirections: points of one direction are lit alike.
  std::uint8_t direction;
  static constexpr std::size_t kDirections = 27;
};

/// One of 27: each axis of the normal negative, about zero or positive.
std::uint8_t direction_of(const Eigen::Vector3f& normal);

/// Steps are taken about a point of the camera's space: translation, and rotation × radius, both in metres.
struct Pivot {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 1;
};

/// The pose after a small step (rows 0–2 translation, 3–5 rotation × radius) about the pivot.
SE3 step_about(const Pivot& pivot, const Twist& step, const SE3& model_to_camera);

/// A model point in the camera, and the crop pixel it falls on.
struct ProjectedPoint {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;
  double u, v;
  int pixel_u, pixel_v;
};

/// Nothing if the point's surface faces away (from 80° on) or it leaves the crop.
std::optional<ProjectedPoint> project(const ModelPoint& model, const LayerView& view, const SE3& model_to_camera);

/// In units of the noise it is value / sigma; `jacobian` is d value / d step at zero.
struct Residual {
  double value;
  double sigma;
  Twist jacobian;
};

/// Which pixels are accepted as correspondences.
struct Gates {
  double distance;      ///< metres, between the model's point and the measured one
  double normal_cosine; ///< of the angle between both normals
};

/// Those with which poses that were found are evaluated.
inline constexpr Gates kEvaluationGates{0.10, kNormalCosine};

/// Metres between the model and what fits it, measured with this standard deviation: 3σ, and 5 mm of the model's own.
constexpr double inlier_distance(double sigma) { return 3 * sigma + 0.005; }

/// The signed distance in metres of the model's point from the measured point at its pixel, along the model's normal.
/// Nothing if the pixel is not the label's, has no depth, or lies outside the gates.
std::optional<Residual> geometric_residual(const ProjectedPoint& projected, const LayerView& view, const Pivot& pivot,
                                           const Gates& gates);

/// Texture of the image minus that of the model that lighting explains, by direction of the normal.
using LightOffsets = std::array<double, ModelPoint::kDirections>;

/// Texture of the image minus that of the model and the light's offset; sigma is 1. Nothing if the point has no texture
/// at that level, lies within two pixels of the label's border or where the view has no detail, or something measured
/// stands before it by more than kPoseMargin.
std::optional<Residual> photometric_residual(const ProjectedPoint& projected, const ModelPoint& model,
                                             const LayerView& view, const Pivot& pivot, int level,
                                             const LightOffsets& light = {});

/// How the textures of image and model differ at a pose: by light (median of each direction), and by what it leaves
/// (a robust standard deviation, at least kMinTextureSigma).
struct TextureModel {
  static constexpr double kMinTextureSigma = 0.02;
  LightOffsets light{};
  double sigma = kMinTextureSigma;
};
TextureModel measure_texture(std::span<const ModelPoint> points, const LayerView& view, const SE3& model_to_camera,
                             int level);

// What follows runs for every point in every step of the solver: it is worth being inlined.

inline std::optional<ProjectedPoint> project(const ModelPoint& model, const LayerView& view,
                                             const SE3& model_to_camera) {
  ProjectedPoint p;
  p.point = model_to_camera * model.position.cast<double>();
  p.normal = model_to_camera.linear() * model.normal.cast<double>();
  const double facing = p.normal.dot(p.point);
  const bool faces_away = !(facing < 0) || facing * facing < kFacingCosine * kFacingCosine * p.point.squaredNorm();
  if (p.point.z() < kNearestDepth || faces_away) return std::nullopt;
  p.u = view.intrinsics.fx * p.point.x() / p.point.z() + view.intrinsics.cx;
  p.v = view.intrinsics.fy * p.point.y() / p.point.z() + view.intrinsics.cy;
  if (!is_in_picture(p.u, p.v, view.intrinsics)) return std::nullopt;
  constexpr double kHalfPixel = 0.5; // from a pixel's middle to its rim
  p.pixel_u = static_cast<int>(p.u + kHalfPixel);
  p.pixel_v = static_cast<int>(p.v + kHalfPixel);
  return p;
}

inline std::optional<Residual> geometric_residual(const ProjectedPoint& p, const LayerView& view, const Pivot& pivot,
                                                  const Gates& gates) {
  if (view.planes.weights.at(p.pixel_u, p.pixel_v) <= 0) return std::nullopt;
  const Eigen::Vector3d measured = view.point(p.pixel_u, p.pixel_v);
  if ((p.point - measured).squaredNorm() > gates.distance * gates.distance) return std::nullopt;
  const float* plane = view.planes.planes.pixel(p.pixel_u, p.pixel_v);
  const double cosine = p.normal.x() * plane[0] + p.normal.y() * plane[1] + p.normal.z() * plane[2];
  if (cosine < gates.normal_cosine) return std::nullopt;
  Residual r;
  r.value = p.normal.dot(p.point - measured);
  r.sigma = kSensorNoise.sigma_across(measured.z(), std::abs(p.normal.dot(measured)) / measured.norm());
  r.jacobian.head<3>() = p.normal;
  // The normal turns with the model: d(n·(x − q)) = n·δ + (ω×n)·(x − q) + n·(ω×(x − c)) = n·δ + ω·((q − c)×n).
  r.jacobian.tail<3>() = (measured - pivot.centre).cross(p.normal) / pivot.radius;
  return r;
}

inline std::optional<Residual> photometric_residual(const ProjectedPoint& p, const ModelPoint& model,
                                                    const LayerView& view, const Pivot& pivot, int level,
                                                    const LightOffsets& light) {
  const float expected = model.texture[static_cast<std::size_t>(level)];
  if (std::isnan(expected) || view.mask.at(p.pixel_u, p.pixel_v) != MaskArea::kInterior) return std::nullopt;
  if (!view.detail.empty() && view.detail.at(p.pixel_u, p.pixel_v) == 0) return std::nullopt;
  const double z = p.point.z();
  const float front = view.depth.at(p.pixel_u, p.pixel_v);
  if (is_occluded(z, front, kPoseMargin)) return std::nullopt;
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

} // namespace kinora::tracking
