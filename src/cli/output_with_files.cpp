#include "cli/output_with_files.h"

#include <system_error>

#include <fmt/format.h>

#include "core/error.h"
#include "host/plugin_table.h"

namespace kinora::cli {
namespace fs = std::filesystem;

OutputWithFiles::OutputWithFiles(const fs::path& path, const KinoraFormat& format, bool overwrite,
                                 const std::vector<fs::path>& inputs)
    : overwrite_(overwrite), output_(path, overwrite, inputs), path_(path) {
  if (!host::supports(format, KINORA_WRITES_FILES_BESIDE)) return;
  if (!output_.can_be_read_back()) {
    throw Error(ErrorCode::kUnwritableOutput,
                fmt::format("{} cannot be written: the format {} puts files beside it; give the name of a file",
                            path.string(), format.name));
  }
  files_.emplace(path);
}

fs::path OutputWithFiles::writing_path() const {
  return files_ ? files_->folder() / path_.filename() : output_.writing_path();
}

std::uintmax_t OutputWithFiles::commit() {
  std::uintmax_t bytes = 0;
  std::error_code ignored;
  if (files_) {
    for (const auto& entry : fs::directory_iterator(files_->folder())) {
      const fs::path target = path_.parent_path() / entry.path().filename();
      bytes += entry.file_size(ignored);
      if (overwrite_ || target.filename() == path_.filename() || !fs::exists(fs::symlink_status(target, ignored)))
        continue;
      throw Error(ErrorCode::kUnwritableOutput,
                  fmt::format("{} cannot be written: it exists already; add --overwrite to replace it, or give another "
                              "name",
                              target.string()));
    }
    files_->move([this](const fs::path& inside) {
      return inside == path_.filename() ? output_.writing_path() : path_.parent_path() / inside;
    });
  } else if (output_.can_be_read_back()) {
    bytes = fs::file_size(output_.writing_path(), ignored);
  }
  output_.commit();
  return bytes;
}

} // namespace kinora::cli
