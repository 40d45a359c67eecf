#include "cli/unfinished.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <set>
#include <string>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "core/error.h"

namespace kinora::cli {
namespace fs = std::filesystem;
namespace {

// Whatever is made is known from the start: making, too, holds the mutex.
std::mutex mutex;
std::set<fs::path>& all_unfinished() {
  static auto* const paths = new std::set<fs::path>; // other threads may need it while the program ends
  return *paths;
}

fs::path candidate(const fs::path& output, int attempt) {
  fs::path path = output;
  path += attempt == 1 ? std::string(".part") : fmt::format(".{}.part", attempt);
  return path;
}

/// 0, or an errno; EEXIST if something is there.
int make(const fs::path& path, Unfinished::Kind kind) {
  if (kind == Unfinished::Kind::kFile) {
    std::FILE* file = std::fopen(path.c_str(), "wbx");
    if (file == nullptr) return errno;
    std::fclose(file);
    return 0;
  }
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) return error.value();
  const bool is_new = fs::create_directory(path, error);
  return error ? error.value() : is_new ? 0 : EEXIST;
}

} // namespace

Unfinished::Unfinished(const fs::path& output, Kind kind) {
  constexpr int kMaxAttempts = 1000;
  const std::lock_guard lock(mutex);
  int error = EEXIST;
  for (int attempt = 1; error == EEXIST && attempt <= kMaxAttempts; ++attempt) {
    path_ = candidate(output, attempt);
    error = make(path_, kind);
  }
  if (error != 0) {
    throw Error(ErrorCode::kUnwritableOutput,
                fmt::format("{} cannot be written: {}", output.string(), std::strerror(error)));
  }
  all_unfinished().insert(path_);
}

Unfinished::~Unfinished() {
  if (kept_) return;
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  keep();
}

void Unfinished::keep() {
  kept_ = true;
  const std::lock_guard lock(mutex);
  all_unfinished().erase(path_);
}

void remove_unfinished_and_exit(int exit_code) {
  constexpr int kAttempts = 100; // others may be writing into a folder
  mutex.lock();
  for (const fs::path& path : all_unfinished()) {
    std::error_code error;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      fs::remove_all(path, error);
      if (!error) break;
    }
  }
  ::_exit(exit_code);
}

} // namespace kinora::cli
