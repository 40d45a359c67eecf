// A room as a moving camera sees it: what finding the camera is tested on.
#pragma once

#include "core/rolling_shutter.h"
#include "synthetic_scene.h"

namespace kinora::tracking::testing {

struct RoomOptions {
  int width = 160;
  int height = 120;
  double focal = 150;
  double noise = 0.25; ///< in units of the sensor's σ(z): what blocks of 4×4 pixels leave of it
  bool textured = true;
  bool furnished = true;  ///< false: bare walls
  bool only_wall = false; ///< nothing but one endless wall at z = 2
  double light = 1;       ///< factor on the colours
  bool covered = false;   ///< something lies on the lens: no light, no depth
  double bow = 0;         ///< depth is told too large by this share × (r/f)²: walls seem bent, and turns too long
  double alike = 0;       ///< > 0: what is in the room repeats along x with this period, metres
  std::uint64_t seed = 3; ///< of the noise
  Twist readout = Twist::Zero(); ///< how the camera moves while the rows are read (rolling_shutter.h)
  /// Something that is no part of the room, 0.5 m wide, at its place in the world; label 1 if `mover_has_label`.
  std::optional<SE3> mover;
  bool mover_has_label = false;
};

/// Walls at x = ±2, y = −1.3 and 1, z = −2 and 3 metres, and three boxes. The first camera stands at the origin.
ingest::Frame render_room(const SE3& camera_to_world, int index, const RoomOptions& options = {});

} // namespace kinora::tracking::testing
