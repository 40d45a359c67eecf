// Bytes that grow beyond what memory should hold.
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace kinora::formats {

/// Appended to, then read once from front to back. Up to 16 MiB stay in memory; the rest goes to a file beside the
/// output, which has no name from the moment it is made, so that nothing is left of it whatever happens. Moveable.
class ByteSpool {
public:
  /// `beside`: the output.
  explicit ByteSpool(std::filesystem::path beside) : beside_(std::move(beside)) {}

  std::size_t size() const { return spooled_ + waiting_.size(); }
  /// Throws Error(kUnwritableOutput), naming the output.
  void append(std::span<const std::byte> bytes);
  /// Appends zeros until the size is a multiple.
  void pad(std::size_t alignment);
  /// Gives all bytes to `take`, piece by piece. Nothing may be appended afterwards. Throws Error(kUnwritableOutput).
  void read(const std::function<void(std::span<const std::byte>)>& take);

private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[noreturn]] void fail() const;
  void spool();

  std::filesystem::path beside_;
  std::vector<std::byte> waiting_;
  std::size_t spooled_ = 0;
  std::unique_ptr<std::FILE, Close> file_; ///< there once something was spooled
};

} // namespace kinora::formats
