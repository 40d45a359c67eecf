// Frames of analytic shapes with known poses: what the trackers are tested on.
#pragma once

#include <cstdint>
#include <optional>

#include "core/se3.h"
#include "ingest/frame/frame.h"

namespace kinora::tracking::testing {

enum class ShapeKind { kBox, kSphere, kCylinder, kPlane };

/// A shape about the origin of its own space: half sides of a box; x is the radius of a sphere and of a cylinder, whose
/// half height is y; a plane is z = 0, facing −z, without end.
struct Shape {
  ShapeKind kind = ShapeKind::kBox;
  Eigen::Vector3d half = {0.12, 0.09, 0.07};
  bool textured = true;
};

struct SceneOptions {
  int width = 240;
  int height = 180;
  double focal = 240;
  double noise = 0; ///< in units of the sensor's σ(z)
  std::uint64_t seed = 1;
  int occluded_columns = 0;       ///< from the left: covered by another label's surface at 0.5 m
  bool occluder_has_label = true; ///< false: the occluder carries the object's own label by mistake
  double light = 1;               ///< factor on the colours
};

/// A frame of 1/30 s in which nothing is seen.
ingest::Frame grey_frame(const SE3& camera_to_world, int index, const SceneOptions& options);

/// The frame that a camera at `camera_to_world` sees of the shape (label 2) before a wall (label 0) at 4 m.
ingest::Frame render_frame(const Shape& shape, const SE3& object_to_world, const SE3& camera_to_world, int index,
                           const SceneOptions& options = {});

/// Where a ray meets the shape, as a factor on its direction; nothing if it does not.
std::optional<double> intersect(const Shape& shape, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction);

/// Signed distance of a box's, sphere's or plane's surface.
double distance_to(const Shape& shape, const Eigen::Vector3d& point);

/// A pose with the object's centre at `centre`, turned about x, y, z in turn (degrees).
SE3 pose_at(const Eigen::Vector3d& centre, double x_degrees, double y_degrees, double z_degrees = 0);

} // namespace kinora::tracking::testing
