#include "cli/output_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "cli/interrupt.h"
#include "core/error.h"

namespace kinora::cli {
namespace fs = std::filesystem;
namespace {

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

} // namespace

OutputFile::OutputFile(fs::path path, bool overwrite, const std::vector<fs::path>& inputs)
    : path_(std::move(path)), writing_path_(path_) {
  std::error_code ignored;
  if (path_.empty()) throw Error(ErrorCode::kUsage, "the name of the file to write is empty; give one");
  if (fs::is_directory(path_, ignored)) unwritable(path_, "it is a folder; give the name of a file");
  device_ = is_device(path_);
  if (device_) return;
  for (const fs::path& input : inputs) {
    if (fs::equivalent(path_, input, ignored)) unwritable(path_, "it is also the input; give another name");
  }
  if (fs::exists(path_, ignored) && !overwrite) {
    unwritable(path_, "it exists already; add --overwrite to replace it, or give another name");
  }
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored)) {
    unwritable(path_, fmt::format("the folder {} does not exist; create it first", folder.string()));
  }
  writing_path_ += ".part";
  std::FILE* file = std::fopen(writing_path_.c_str(), "wb");
  if (file == nullptr) unwritable(path_, std::strerror(errno));
  std::fclose(file);
  remember_unfinished(writing_path_);
}

OutputFile::~OutputFile() {
  if (device_ || committed_ || writing_path_ == path_) return;
  std::error_code ignored;
  fs::remove(writing_path_, ignored);
  remember_unfinished({});
}

void OutputFile::commit() {
  committed_ = true;
  if (device_) return;
  std::error_code error;
  fs::rename(writing_path_, path_, error);
  remember_unfinished({});
  if (!error) return;
  std::error_code ignored;
  fs::remove(writing_path_, ignored);
  unwritable(path_, error.message());
}

void write_text(OutputFile& output, std::string_view text) {
  write_whole(output.writing_path(), text);
  output.commit();
}

} // namespace kinora::cli
