// Pieces of a large file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace kinora::formats {

/// Moveable. Different threads need different ones.
class RandomAccessFile {
public:
  /// Throws Error(kCorruptInput), naming the path, if it is no regular file that can be opened.
  explicit RandomAccessFile(const std::filesystem::path& path);
  RandomAccessFile(RandomAccessFile&& other) noexcept;
  RandomAccessFile(const RandomAccessFile&) = delete;
  RandomAccessFile& operator=(const RandomAccessFile&) = delete;
  RandomAccessFile& operator=(RandomAccessFile&&) = delete;
  ~RandomAccessFile();

  std::uint64_t size() const { return size_; }
  const std::string& name() const { return name_; }
  /// Throws Error(kCorruptInput) before anything is allocated if the piece goes beyond the end of the file.
  std::vector<std::byte> read(std::uint64_t offset, std::uint64_t count) const;

private:
  std::string name_;
  int descriptor_;
  std::uint64_t size_ = 0;
};

} // namespace kinora::formats
