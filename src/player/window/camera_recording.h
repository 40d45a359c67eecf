// A camera's path on its way into a transforms.json.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "core/camera.h"

namespace kinora::player::window {

/// Becomes a file as read_camera_file() (player/camera_file.h) reads it.
class CameraRecording {
public:
  /// `seconds` of the clip. The same camera at the same time as the last one is left out.
  void add(const Camera& camera, double seconds);
  std::size_t size() const { return frames_.size(); }
  std::string text() const;

private:
  nlohmann::json frames_ = nlohmann::json::array();
};

} // namespace kinora::player::window
