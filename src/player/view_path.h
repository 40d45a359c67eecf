// Where the camera stands for each picture that is drawn: along the capture's path, or beside it.
#pragma once

#include <string>
#include <vector>

#include "core/camera.h"
#include "player/player.h"

namespace kinora::player {

/// One picture to draw.
struct View {
  Camera camera;
  double frame = 0; ///< of the clip, may be fractional
  std::string name; ///< relative name of the picture's file, without suffix
};

/// The capture camera at each of `frames` (numbers into the clip's timeline). Names are six-digit frame numbers.
std::vector<View> capture_views(const clip::Clip& clip, const std::vector<int>& frames);

/// The capture camera carried about the vertical through what the scene is about: the first moving layer's centre, its
/// mean over `frames`, or, if nothing moves, still_subject (player/subject.h). Vertical is the capture camera's −y
/// axis. `degrees` > 0 goes to the camera's right. A single frame is seen from `degrees`; several swing from 0 to
/// +degrees, to −degrees and back to 0, once (angle = degrees · sin(2π i / n)).
std::vector<View> orbit_views(const Player& player, const std::vector<int>& frames, double degrees);

/// `camera` turned by `radians` about the line through `pivot` along its own −y axis; positive goes to its right.
Camera orbited(const Camera& camera, const Eigen::Vector3d& pivot, double radians);

} // namespace kinora::player
