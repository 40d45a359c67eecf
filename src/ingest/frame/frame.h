// One instant of a capture, ready for tracking and training.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "ingest/frame/joint_detection.h"

namespace kinora::ingest {

/// Colour and depth are registered: the same pixel is the same ray. All images have the camera's size.
struct Frame {
  int index = 0;          ///< position in the capture, from 0 (skipped frames keep their number)
  double time = 0;        ///< seconds since the capture's first frame
  Camera camera;          ///< undistorted; world = the capture camera of frame 0, unless the capture brings poses
  ColorImage color;       ///< 3 channels sRGB
  DepthImage depth;       ///< as measured, metres, 0 = no measurement; what metrics call "measured depth"
  DepthImage clean_depth; ///< `depth` without flying pixels, jumps, grazing surfaces and a border: for fusion only
  LabelImage labels;      ///< 0 background, 1 person, 2…; empty: the frame has none (has_labels)
  std::vector<DetectedPerson> people; ///< whose joints a detector has looked for; one for each label at most

  bool has_labels() const { return !labels.empty(); }
  /// Background where the frame has no labels.
  std::uint8_t label_at(int u, int v) const { return labels.empty() ? 0 : labels.at(u, v); }
};

} // namespace kinora::ingest
