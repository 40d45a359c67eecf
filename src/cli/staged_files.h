// A folder beside an output in which a writer makes files, and from which they go to their places when they are whole.
#pragma once

#include <filesystem>
#include <functional>

#include "cli/unfinished.h"

namespace kinora::cli {

class StagedFiles {
public:
  /// Throws Error(kUnwritableOutput), naming `output`.
  explicit StagedFiles(const std::filesystem::path& output) : folder_(output, Unfinished::Kind::kFolder) {}

  const std::filesystem::path& folder() const { return folder_.path(); }
  /// Moves every file to where `destination` says of its path inside the folder, in the order of their names. Throws
  /// Error(kUnwritableOutput), and what `destination` throws.
  void move(const std::function<std::filesystem::path(const std::filesystem::path& inside)>& destination) const;

private:
  Unfinished folder_;
};

} // namespace kinora::cli
