// A file that libebml writes into, whose every failure is an Error that names it.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>

#include <ebml/IOCallback.h>

namespace kinora::container {

/// Not thread-safe. Every method throws Error(kUnwritableOutput) when the system refuses.
class FileSink final : public libebml::IOCallback {
public:
  explicit FileSink(std::filesystem::path path);
  ~FileSink() override;
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  std::uint32_t read(void* buffer, std::size_t size) override;
  void setFilePointer(std::int64_t offset, libebml::seek_mode mode = libebml::seek_beginning) override;
  std::size_t write(const void* buffer, std::size_t size) override;
  std::uint64_t getFilePointer() override { return position_; }
  /// Flushes and closes: a full disk may show only here.
  void close() override;

private:
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
  std::uint64_t position_ = 0; // counted here: devices such as /dev/full do not know theirs
};

} // namespace kinora::container
