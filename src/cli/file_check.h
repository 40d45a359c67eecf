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

/// Throws Error(kCorruptInput) that says in how many places, and where the first is.
void throw_if_damaged(const FileCheck& check, const std::filesystem::path& path);

} // namespace kinora::cli
