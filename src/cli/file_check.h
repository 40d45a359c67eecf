// Whether every part of a file of ours is sound.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.h"

namespace kinora::cli {

struct FileCheck {
  std::string kind;                ///< "clip" or "recording"
  std::vector<std::string> damage; ///< sentences; empty: all is sound
};

/// Reads, checks and decodes everything. Throws Error: kNotRecognised, kCorruptInput if the head cannot be read.
FileCheck check_file(const std::filesystem::path& path, Progress& progress);

} // namespace kinora::cli
