#include <system_error>

#include <fmt/format.h>

#include "cli/conversion.h"
#include "core/error.h"

namespace kinora::cli {
namespace fs = std::filesystem;

fs::path numbered_path(const fs::path& path, std::size_t index) {
  return path.parent_path() / fmt::format("{}_{:04}{}", path.stem().string(), index + 1, path.extension().string());
}

void check_numbered_outputs(const Conversion& conversion, bool overwrite) {
  std::error_code ignored;
  const fs::path folder = conversion.output.parent_path();
  if (!folder.empty()) fs::create_directory(folder, ignored); // what fails here is told of by the first file
  for (std::size_t i = 0; i < conversion.frames.size() && !overwrite && !conversion.resume; ++i) {
    const fs::path path = numbered_path(conversion.output, i);
    if (!fs::exists(path, ignored)) continue;
    throw Error(
        ErrorCode::kUnwritableOutput,
        fmt::format("{} cannot be written: it exists already; add --overwrite to replace it, --resume to write those "
                    "that are missing, or give another name",
                    path.string()));
  }
}

bool is_done(const Conversion& conversion, const fs::path& path) {
  std::error_code ignored;
  return conversion.resume && fs::exists(path, ignored);
}

} // namespace kinora::cli
