// A volumetric video in memory: layers, timeline, camera path and metadata.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "container/sound.h"
#include "core/camera.h"
#include "fields/model/confidence.h"
#include "fields/model/field.h"
#include "motion/joint_paths.h"
#include "motion/motion.h"
#include "motion/node_births.h"
#include "motion/presence.h"

namespace kinora::clip {

struct Layer {
  std::string name; ///< unique within the clip: background, person, object, object2, …
  int label = 0;    ///< of the capture's masks
  fields::Field field;
  motion::Motion motion = motion::Motion::still();
  std::optional<fields::Confidence> confidence = std::nullopt; ///< of the field; files of earlier versions have none
  std::optional<motion::JointPaths> joints = std::nullopt;     ///< of a deforming layer that is a person
  motion::Presence presence = {};                              ///< frames at which it is there; usually all
  motion::NodeBirths births = {};                              ///< of a deforming layer
};

struct Clip {
  std::vector<double> times;        ///< seconds from the start, one per frame, increasing
  std::vector<int> capture_frames;  ///< number of each frame in the capture
  std::vector<bool> held_out;       ///< frames that nothing was trained on
  Intrinsics intrinsics;            ///< of the capture camera
  std::vector<SE3> camera_to_world; ///< path of the capture camera: one pose per frame, or one for all if it is still
  std::vector<Layer> layers;
  std::optional<container::Sound> sound = std::nullopt; ///< times as those of the frames
  nlohmann::json metadata = nlohmann::json::object(); ///< configuration of the run, what was modelled and why, versions

  Camera capture_camera(double frame) const; ///< interpolated along the path
  double frame_at(double seconds) const;     ///< fractional frame number at a time, clamped
};

} // namespace kinora::clip
