// glTF and GLB files as scenes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gltf_scene/scene.h"

namespace kinora::formats {

/// Reads the file's default scene (else all nodes), with buffers and pictures that lie in it, in data: URIs, or in its
/// folder. `warnings` gets a sentence for what is passed over. Throws Error(kCorruptInput), naming the path, if it is
/// no glTF 2.0, needs an extension that is not known, or contradicts itself.
Scene read_gltf(const std::filesystem::path& path, std::vector<std::string>& warnings);

} // namespace kinora::formats
