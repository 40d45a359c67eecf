// glTF files through tinygltf, which knows no limits: what it may open is limited here.
#pragma once

#include <filesystem>

#include "gltf_scene/gltf_library.h"

namespace kinora::formats {

/// The parsed file with its buffers and decoded pictures (3 channels, sRGB). Nothing outside of the file's folder is
/// read. Throws Error(kCorruptInput), naming the path.
tinygltf::Model load_gltf_model(const std::filesystem::path& path);

} // namespace kinora::formats
