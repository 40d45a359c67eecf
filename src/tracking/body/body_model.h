// Surface of a person: a rounded cone, flattened where bodies are flat, about each bone.
// Source: Tkach, Pauly, Tagliasacchi, "Sphere-Meshes for Real-Time Hand Modeling and Tracking", SIGGRAPH Asia 2016 (of
// whose elements this uses the pill alone). Sizes are rough means after Winter, 2009, and NASA-STD-3000, vol. I, 3.3.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tracking/body/skeleton.h"

namespace kinora::tracking {

/// The hull of two spheres in a bone's space, in body heights; x is then stretched by `width`.
struct BodyPart {
  Joint bone;
  Eigen::Vector3d a, b;
  double radius_a, radius_b;
  Measure length;           ///< scales a and b
  Measure girth_a, girth_b; ///< scale the radii
  double width = 1;
  std::optional<Measure> width_measure = std::nullopt;
  bool has_tip = false; ///< b's sphere ends the body
};

constexpr std::size_t kBodyParts = 21;
const std::array<BodyPart, kBodyParts>& body_parts();

/// A part in metres.
struct PartShape {
  Eigen::Vector3d a, b;
  double radius_a, radius_b;
  double width;
  Eigen::Vector3d axis; ///< unit, from a to b
  double length;
  double sin_half_angle, tan_half_angle; ///< of the radius along the axis: sine and tangent of the cone's half angle
  Eigen::Vector3d centre;                ///< of a ball that holds the part
  double reach;                          ///< radius of the ball
};
PartShape shape_of(const BodyPart& part, const Shape& shape);

/// A point of a part's surface: on the sphere about a + along · (b − a), in `direction` (before x is stretched).
struct PartPoint {
  double along;
  Eigen::Vector3d direction; ///< unit
};
Eigen::Vector3d position_of(const PartShape& part, const PartPoint& point);
Eigen::Vector3d normal_of(const PartShape& part, const PartPoint& point);
/// The same at some length.
Eigen::Vector3d gradient_of(const PartShape& part, const PartPoint& point);

/// The surface nearest to a point: exact where width is 1, else to first order in the distance.
struct ClosestSurface {
  double distance; ///< negative inside
  Eigen::Vector3d normal;
  PartPoint point;
};
ClosestSurface closest_surface(const PartShape& part, const Eigen::Vector3d& position);

/// What a part's own measures do to it: how fast position_of(point) moves along `direction` (both in the bone's space)
/// with its length, both girths, its width and the height of the body.
constexpr int kPartMeasures = 5;
Eigen::Matrix<double, kPartMeasures, 1> measure_derivative(const PartShape& part, const PartPoint& point,
                                                           const Eigen::Vector3d& direction);
/// Those measures; none where a part has no width of its own.
std::array<std::optional<Measure>, kPartMeasures> measures_of(const BodyPart& part);

/// Points spread evenly over the surface of the whole body, part after part, none inside another.
struct BodySample {
  std::size_t part;
  PartPoint point;
  double area; ///< metres², for a body of mean size
};
std::span<const BodySample> body_samples();
std::span<const BodySample> samples_of(std::size_t part);

/// The posed body: where its parts are.
struct PosedBody {
  Bones bones;
  std::array<PartShape, kBodyParts> parts;
};
PosedBody pose_body(const BodyPose& pose, const Shape& shape);

} // namespace kinora::tracking
