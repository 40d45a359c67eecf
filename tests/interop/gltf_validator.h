// Khronos' glTF validator, if tests/interop/install has fetched it.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <string>

#include "support/source_folder.h"

namespace kinora::test {

inline bool has_gltf_validator() {
  return std::filesystem::exists(source_folder() / "tests/interop/node_modules/gltf-validator") &&
         std::system("node --version > /dev/null 2>&1") == 0;
}

/// Whether the validator finds nothing to say about the files.
inline bool is_valid_gltf(std::initializer_list<std::filesystem::path> files) {
  std::string command = "node '" + source_folder().string() + "/tests/interop/validate_gltf.mjs'";
  for (const std::filesystem::path& file : files) command += " '" + file.string() + "'";
  return std::system(command.c_str()) == 0;
}

} // namespace kinora::test
