// Which topics of a log are the colour and the depth camera, and how these stand to each other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "ros/message_log.h"

namespace kinora::formats {

/// A camera's images.
struct CameraTopic {
  std::size_t channel = 0;
  bool compressed = false;
  std::string encoding; ///< of the first image
  std::string frame_id;
  Intrinsics intrinsics;
  Distortion distortion;
};

struct CameraTopics {
  CameraTopic color;
  CameraTopic depth;
  std::optional<SE3> depth_to_color; ///< nothing: depth is registered to colour
  double depth_unit = 0.001;         ///< metres
  std::vector<std::string> warnings;
};

/// `color` and `depth` name topics; where empty the likeliest are taken: aligned depth before other depth, and raw
/// images before compressed ones. Throws Error(kCorruptInput), listing what there is, if there is no colour or no
/// depth, no calibration, or no word about how two cameras stand.
CameraTopics find_camera_topics(MessageReader& reader, const std::string& color, const std::string& depth);

} // namespace kinora::formats
