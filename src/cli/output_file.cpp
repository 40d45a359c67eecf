#include "cli/output_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>

#include "core/error.h"

namespace kinora::cli {
namespace fs = std::filesystem;
namespace {

// Of the one thread that writes outputs.
std::vector<const OutputFile*>& living_outputs() {
  static std::vector<const OutputFile*> outputs;
  return outputs;
}

[[noreturn]] void unwritable(const fs::path& path, const std::string& why) {
  throw Error(ErrorCode::kUnwritableOutput, fmt::format("{} cannot be written: {}", path.string(), why));
}

bool is_device(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

void write_whole(const fs::path& path, std::string_view text) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) unwritable(path, std::strerror(errno));
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const bool closed = std::fclose(file) == 0;
  if (!written || !closed) unwritable(path, std::strerror(errno));
}

/// 0, or an errno; EEXIST if `to` exists and must not be replaced.
int move_file(const fs::path& from, const fs::path& to, bool replace) {
  if (!replace) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
    if (errno != EINVAL && errno != ENOSYS) return errno;
    std::error_code ignored; // a file system that cannot do both in one step
    if (fs::exists(to, ignored)) return EEXIST;
  }
  return std::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

} // namespace

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored) ||
         fs::weakly_canonical(fs::absolute(a)) == fs::weakly_canonical(fs::absolute(b));
}

OutputFile::OutputFile(fs::path path, bool overwrite, const std::vector<fs::path>& inputs)
    : path_(std::move(path)), overwrite_(overwrite) {
  std::error_code ignored;
  if (path_.empty()) throw Error(ErrorCode::kUsage, "the name of the file to write is empty; give one");
  if (fs::is_directory(path_, ignored)) unwritable(path_, "it is a folder; give the name of a file");
  device_ = is_device(path_);
  if (device_) return;
  for (const fs::path& input : inputs) {
    if (fs::equivalent(path_, input, ignored)) unwritable(path_, "it is also the input; give another name");
  }
  for (const OutputFile* other : living_outputs()) {
    if (!same_file(path_, other->path_)) continue;
    unwritable(path_, "another output of this command has the same name; give another name");
  }
  if (fs::exists(fs::symlink_status(path_, ignored)) && !overwrite) {
    unwritable(path_, "it exists already; add --overwrite to replace it, or give another name");
  }
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored)) {
    unwritable(path_, fmt::format("the folder {} does not exist; create it first", folder.string()));
  }
  unfinished_.emplace(path_, Unfinished::Kind::kFile);
  living_outputs().push_back(this);
}

OutputFile::~OutputFile() { std::erase(living_outputs(), this); }

void OutputFile::commit() {
  if (device_) return;
  const int error = move_file(unfinished_->path(), path_, overwrite_);
  if (error == 0 || error == EEXIST) unfinished_->keep();
  if (error == EEXIST) {
    unwritable(path_, fmt::format("a file of this name appeared meanwhile; what was made is {}",
                                  unfinished_->path().string()));
  }
  if (error != 0) unwritable(path_, std::strerror(error));
}

void write_text(OutputFile& output, std::string_view text) {
  write_whole(output.writing_path(), text);
  output.commit();
}

} // namespace kinora::cli
