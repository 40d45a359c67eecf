// What one point of a rigid model says about its pose in one view: a distance along its normal, and a texture.
// Sources: Chen and Medioni, "Object modelling by registration of multiple range images", 1992 (point to plane);
// Baker and Matthews, "Lucas-Kanade 20 Years On", IJCV 2004 (texture).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/se3.h"
#include "tracking/object_view.h"

namespace kinora::tracking {

/// A point of the model's surface, in the model's own coordinates (metres, near its origin).
struct ModelPoint {
  Eigen::Vector3f position;
  Eigen::Vector3f normal; ///< unit, out of the surface
  /// Texture expected at each level of ObjectView::pyramid; NaN where none is.
  std::array<float, ObjectView::kLevels> texture;
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
std::optional<ProjectedPoint> project(const ModelPoint& model, const ObjectView& view, const SE3& model_to_camera);

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

/// The signed distance in metres of the model's point from the measured point at its pixel, along the model's normal.
/// Nothing if the pixel is not the label's, has no depth, or lies outside the gates.
std::optional<Residual> geometric_residual(const ProjectedPoint& projected, const ObjectView& view, const Pivot& pivot,
                                           const Gates& gates);

/// Texture of the image minus that of the model that lighting explains, by direction of the normal.
using LightOffsets = std::array<double, ModelPoint::kDirections>;

/// Texture of the image minus that of the model and the light's offset; sigma is 1. Nothing if the point has no texture
/// at that level, lies within two pixels of the label's border, or something measured stands before it by more than
/// max(3 cm, 3σ).
std::optional<Residual> photometric_residual(const ProjectedPoint& projected, const ModelPoint& model,
                                             const ObjectView& view, const Pivot& pivot, int level,
                                             const LightOffsets& light = {});

/// How the textures of image and model differ at a pose: by light (median of each direction), and by what it leaves
/// (a robust standard deviation, at least kMinTextureSigma).
struct TextureModel {
  static constexpr double kMinTextureSigma = 0.02;
  LightOffsets light{};
  double sigma = kMinTextureSigma;
};
TextureModel measure_texture(std::span<const ModelPoint> points, const ObjectView& view, const SE3& model_to_camera,
                             int level);

} // namespace kinora::tracking
