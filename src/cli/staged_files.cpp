#include "cli/staged_files.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::cli {
namespace fs = std::filesystem;

void StagedFiles::move(const std::function<fs::path(const fs::path& inside)>& destination) const {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder())) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const fs::path target = destination(file.lexically_relative(folder()));
    std::error_code error;
    if (target.has_parent_path()) fs::create_directories(target.parent_path(), error);
    fs::rename(file, target, error);
    if (error) {
      throw Error(ErrorCode::kUnwritableOutput,
                  fmt::format("{} cannot be written: {}", target.string(), error.message()));
    }
  }
}

} // namespace kinora::cli
