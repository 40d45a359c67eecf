// What stands beside a clip in its file for people and for ordinary players: a flat preview, a poster, chapters, tags.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/context.h"
#include "container/payload.h"

namespace kinora::cli {

/// As the command line gives them.
struct CompanionOptions {
  bool preview = false;
  std::filesystem::path chapters;
  std::vector<std::string> tags; ///< NAME=VALUE
};

/// What was asked for, understood.
struct Companions {
  bool preview = false;
  std::vector<container::Chapter> chapters; ///< empty: as they are
  container::Tags tags;                     ///< replace those of the same names; an empty value removes one

  bool empty() const { return !preview && chapters.empty() && tags.empty(); }
};

void add_companion_options(CLI::App& command, CompanionOptions& options);

/// Throws Error: kUsage, kCorruptInput naming the file and line.
Companions companions_of(const CompanionOptions& options);

/// Rewrites the clip's file with them. Chapters behind its last frame are left out, with a warning. Throws Error:
/// kUnwritableOutput, kMissingComponent (no encoder for the preview), kInterrupted; then the file is as it was.
void add_companions(const std::filesystem::path& clip_file, const Companions& companions, Context& context);

} // namespace kinora::cli
