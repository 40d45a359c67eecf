// What the format of animated scenes says of itself.
#pragma once

#include "common/boundary.h"

namespace kinora::formats {

inline constexpr KinoraOption kGltfSceneOptions[] = {
    {"width", "int", "640", "Pixels of the virtual camera.", nullptr},
    {"height", "int", "480", "Pixels of the virtual camera.", nullptr},
    {"fps", "number", "30", "Frames per second of the animation.", nullptr},
    {"camera", "text", "", "Name or number (from 1) of a camera of the file, or \"auto\"; else the first, or auto.",
     nullptr},
    {"fov", "number", "50", "Degrees from top to bottom that an automatic camera sees.", nullptr},
    {"animation", "text", "", "Name or number (from 1) of an animation; else the first.", nullptr},
    {"masks", "bool", "true", "Give every mesh that moves a label.", nullptr}};

/// Without functions.
constexpr KinoraFormat gltf_scene_description() {
  return describe("gltf-scene", "animated glTF or GLB before a virtual RGB-D camera: base colours, exact depth", "",
                  KINORA_READS_FRAMES | KINORA_SEEKS | KINORA_READS_POSES | KINORA_READS_MASKS, kGltfSceneOptions);
}

} // namespace kinora::formats
