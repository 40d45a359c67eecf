// Where a rigid model is in one view: point-to-plane distances and texture together, by Levenberg–Marquardt.
// Sources: Chen and Medioni, "Object modelling by registration of multiple range images", 1992 (point to plane);
// Baker and Matthews, "Lucas-Kanade 20 Years On", IJCV 2004; Gelfand et al., "Geometrically Stable Sampling for the ICP
// Algorithm", 3DIM 2003 (weak directions are small eigenvalues of the information with rotations scaled to metres).
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

/// Texture of the image minus that of the model that lighting explains, by direction of the normal.
using LightOffsets = std::array<double, ModelPoint::kDirections>;

/// Steps are taken about a point of the camera's space: translation, and rotation × radius, both in metres.
struct Pivot {
  Eigen::Vector3d centre;
  double radius;
};

/// The pose after a small step (rows 0–2 translation, 3–5 rotation × radius) about the pivot.
SE3 step_about(const Pivot& pivot, const Twist& step, const SE3& model_to_camera);

/// One residual in units of its own noise σ is value / sigma; `jacobian` is d value / d step at zero.
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
/// Nothing if it faces away, leaves the crop, or no pixel of the label with depth lies within the gates.
std::optional<Residual> geometric_residual(const ModelPoint& point, const ObjectView& view, const SE3& model_to_camera,
                                           const Pivot& pivot, const Gates& gates);

/// Texture of the image minus that of the model and the light's offset; sigma is 1. Nothing if the point faces away,
/// has no texture at that level, lies within two pixels of the label's border, or something measured stands before it
/// by more than max(3 cm, 3σ).
std::optional<Residual> photometric_residual(const ModelPoint& point, const ObjectView& view,
                                             const SE3& model_to_camera, const Pivot& pivot, int level,
                                             const LightOffsets& light = {});

/// How well a pose explains the view, at the finest level.
struct AlignmentQuality {
  std::size_t on_label = 0;       ///< model points that face the camera and fall on a pixel of the label with depth
  std::size_t inliers = 0;        ///< of these, those within 3σ + 5 mm and 45°
  double median_distance = 0;     ///< of |point-to-plane| over inliers, metres
  double texture_correlation = 0; ///< of image and model, in [−1, 1]; 0 if there is too little texture to tell
  double inlier_share() const {
    return on_label > 0 ? static_cast<double>(inliers) / static_cast<double>(on_label) : 0.0;
  }
};

AlignmentQuality judge_pose(std::span<const ModelPoint> points, const ObjectView& view, const SE3& model_to_camera);

struct AlignmentConfig {
  bool coarse = true;       ///< false: only the finest stage
  double weak_share = 0.01; ///< a direction is weak if its information is below this share of what the same points
                            ///< would give along their normals
  double texture_tolerance = 0.003; ///< metres; texture that fixes a direction to this supports it, whatever depth says
  double photometric_share = 0.3;   ///< neighbouring pixels are not independent: weight of the texture term
};

struct Alignment {
  SE3 model_to_camera = SE3::Identity();
  /// How the data support each direction about the pivot, ascending; 1/m².
  Twist eigenvalues = Twist::Zero();
  Eigen::Matrix<double, 6, 6> directions = Eigen::Matrix<double, 6, 6>::Identity(); ///< columns: eigenvectors
  int weak_directions = 0; ///< the first so many were left to the prior
  std::size_t geometric_terms = 0;
  std::size_t photometric_terms = 0;
  int iterations = 0;
};

/// Refines `start`. Directions that the data leave open follow `prior` (both model to camera). With no usable point
/// the result is the prior with six weak directions. Deterministic; thread-safe.
Alignment align(std::span<const ModelPoint> points, const ObjectView& view, const SE3& start, const SE3& prior,
                const AlignmentConfig& config = {});

/// Solves information · step = −gradient. Directions in which `support` (symmetric) has an eigenvalue below
/// `weak_below` are taken from `toward_prior` (a step); the others are solved for, their diagonal damped by the factor
/// 1 + damping. Finite for every finite input.
struct DampedStep {
  Twist step;
  Twist eigenvalues; ///< of the support, ascending
  Eigen::Matrix<double, 6, 6> directions;
  int weak_directions;
};
DampedStep solve_with_prior(const Eigen::Matrix<double, 6, 6>& information, const Eigen::Matrix<double, 6, 6>& support,
                            const Twist& gradient, const Twist& toward_prior, double weak_below, double damping);

} // namespace kinora::tracking
