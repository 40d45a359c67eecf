// A file that libebml writes into, whose every failure is an Error that names it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

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
  /// Hands everything to the system: who follows the file sees it. `durable`: and waits until the disk has it.
  void flush(bool durable);
  /// Forgets what is not yet written and shortens the file; writing goes on at its end. Works on a full disk.
  void cut(std::uint64_t size);
  /// Flushes and closes: a full disk may show only here.
  void close() override;

private:
  void drain();
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path path_;
  int file_ = -1;
  std::uint64_t position_ = 0; // counted here: devices such as /dev/full do not know theirs
  std::vector<std::byte> buffer_;
};

} // namespace kinora::container
