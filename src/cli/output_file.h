// A file that appears under its name only when it is whole.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/unfinished.h"

namespace kinora::cli {

/// Checks at once that `path` can be written, lets the caller write `writing_path()` (an Unfinished file), and renames
/// it in `commit()`. Without commit the unfinished file is removed and what stood at `path` stays as it was.
/// A device (such as /dev/null) is written in place. Not thread-safe.
class OutputFile {
public:
  /// Throws Error(kUnwritableOutput) if the file exists and `overwrite` is false, is one of `inputs` or of the outputs
  /// that live already, or cannot be created.
  OutputFile(std::filesystem::path path, bool overwrite, const std::vector<std::filesystem::path>& inputs = {});
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& writing_path() const { return unfinished_ ? unfinished_->path() : path_; }
  bool can_be_read_back() const { return !device_; }
  /// Throws Error(kUnwritableOutput). What appeared at `path` since the constructor is not replaced, unless
  /// `overwrite`: the file is left under its unfinished name then.
  void commit();

private:
  std::filesystem::path path_;
  bool overwrite_;
  bool device_ = false;
  std::optional<Unfinished> unfinished_;
};

/// Writes `text` to the output and commits it. Throws Error(kUnwritableOutput), also when the disk is full.
void write_text(OutputFile& output, std::string_view text);

/// Whether both name one file, which need not exist yet. Links are followed.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

} // namespace kinora::cli
