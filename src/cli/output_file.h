// A file that appears under its name only when it is whole.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace kinora::cli {

/// Checks at once that `path` can be written, lets the caller write `writing_path()` (path + ".part"), and renames it
/// in `commit()`. Without commit the unfinished file is removed and what stood at `path` stays as it was.
/// A device (such as /dev/null) is written in place. Not thread-safe.
class OutputFile {
public:
  /// Throws Error(kUnwritableOutput) if the file exists and `overwrite` is false, is one of `inputs`, or cannot be
  /// created.
  OutputFile(std::filesystem::path path, bool overwrite, const std::vector<std::filesystem::path>& inputs = {});
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& writing_path() const { return writing_path_; }
  bool can_be_read_back() const { return !device_; }
  /// Throws Error(kUnwritableOutput).
  void commit();

private:
  std::filesystem::path path_;
  std::filesystem::path writing_path_;
  bool device_ = false;
  bool committed_ = false;
};

/// Writes `text` to the output and commits it. Throws Error(kUnwritableOutput), also when the disk is full.
void write_text(OutputFile& output, std::string_view text);

} // namespace kinora::cli
