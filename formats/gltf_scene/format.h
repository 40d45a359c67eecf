// Animated scenes before a virtual camera, for the table of built-in formats. The tinygltf library is in a module
// (module.cpp), which is left out where the library is not there when Kinora is built.
#pragma once

#include "kinora/plugin.h"

namespace kinora::formats {

const KinoraFormat& gltf_scene_format();

/// As the plugin interface's `probe`, but that it may throw Error.
void probe_gltf_scene(const char* path, KinoraProbe* answer);

} // namespace kinora::formats
