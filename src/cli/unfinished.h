// What holds an output until it is whole.
#pragma once

#include <filesystem>

namespace kinora::cli {

/// An empty file or folder beside an output, under the first free name of OUT.part, OUT.2.part, …: nothing that was
/// there before is touched. It is removed when it is destroyed, and when the program has to end at once. One thread at
/// a time each.
class Unfinished {
public:
  enum class Kind { kFile, kFolder };
  /// Throws Error(kUnwritableOutput), naming `output`.
  Unfinished(const std::filesystem::path& output, Kind kind);
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;
  ~Unfinished();

  const std::filesystem::path& path() const { return path_; }
  /// Leaves it where it is, or nothing if it was moved away.
  void keep();

private:
  std::filesystem::path path_;
  bool kept_ = false;
};

/// Ends the program without destructors, with all that is unfinished removed. Any thread.
[[noreturn]] void remove_unfinished_and_exit(int exit_code);

} // namespace kinora::cli
