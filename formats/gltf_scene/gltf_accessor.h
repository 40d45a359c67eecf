// Numbers out of a glTF file's buffers, which are not trusted.
#pragma once

#include <string>
#include <vector>

#include "gltf_scene/gltf_library.h"

namespace kinora::formats {

/// `width` numbers for each of `count` elements, one after another.
struct GltfNumbers {
  std::size_t width = 0;
  std::size_t count = 0;
  std::vector<double> values;
};

/// The accessor's numbers; integers that are normalized lie within -1 and 1. Sparse accessors too. Throws
/// Error(kCorruptInput), naming `source`, if the accessor does not exist or reaches beyond its buffer, or a number is
/// not finite.
GltfNumbers read_accessor(const tinygltf::Model& model, int accessor, const std::string& source);

} // namespace kinora::formats
