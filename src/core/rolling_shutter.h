// A picture that is read row by row while its camera moves: what each row shows is of another moment.
// Source: Hedborg, Forssén, Felsberg and Ringaby, "Rolling Shutter Bundle Adjustment", CVPR 2012; here the camera moves
// evenly while a picture is read, to first order.
#pragma once

#include <span>
#include <vector>

#include "core/camera.h"
#include "core/se3.h"

namespace kinora {

/// When a row is read, in parts of the time that all rows take: from −½ (first) to ½ (last). A frame's pose is that of
/// the middle.
inline double row_time(double v, int height) { return (v + 0.5) / height - 0.5; }

/// Of a pixel, in the camera as it stands at the middle row: at depth z it shows origin + z · direction, metres.
struct RowRay {
  Eigen::Vector3d origin, direction;
};

/// `readout`: how the camera moves while all rows are read, in its own space.
inline RowRay row_ray(const Intrinsics& intrinsics, double u, double v, const Twist& readout) {
  const double time = row_time(v, intrinsics.height);
  const Eigen::Vector3d direction = intrinsics.unproject(u, v, 1.0);
  return {time * readout.head<3>(), direction + time * readout.tail<3>().cross(direction)};
}

/// The motion of a camera while all rows of a picture are read, which takes `seconds`, in each frame of a path: by how
/// it moves from the frame before to the one after, or on one side of the frame if the path jumps on the other (a
/// camera that was lost and found).
std::vector<Twist> readout_motion(std::span<const SE3> camera_to_world, std::span<const double> times, double seconds);

} // namespace kinora
