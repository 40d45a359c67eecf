// Where records are read from: the file itself, or a chunk of it that was unpacked.
#pragma once

#include <optional>
#include <vector>

#include "common/byte_reader.h"
#include "common/random_access_file.h"

namespace kinora::formats {

class LogBytes {
public:
  explicit LogBytes(const RandomAccessFile& file) : file_(&file), size_(file.size()) {}
  LogBytes(const std::vector<std::byte>& chunk, std::size_t number)
      : memory_(&chunk), size_(chunk.size()), chunk_(number) {}
  /// A part of the file that is not compressed.
  LogBytes(const RandomAccessFile& file, std::uint64_t end) : file_(&file), size_(end) {}

  std::uint64_t size() const { return size_; }
  std::optional<std::size_t> chunk() const { return chunk_; }
  /// Throws Error(kCorruptInput) if the piece goes beyond the end.
  std::vector<std::byte> read(std::uint64_t offset, std::uint64_t count, const std::string& source) const {
    if (offset > size_ || count > size_ - offset)
      throw Error(ErrorCode::kCorruptInput, source + ": a record at byte " + std::to_string(offset) + " is cut off");
    if (file_ != nullptr) return file_->read(offset, count);
    const auto begin = memory_->begin() + static_cast<std::ptrdiff_t>(offset);
    return {begin, begin + static_cast<std::ptrdiff_t>(count)};
  }

private:
  const RandomAccessFile* file_ = nullptr;
  const std::vector<std::byte>* memory_ = nullptr;
  std::uint64_t size_;
  std::optional<std::size_t> chunk_;
};

} // namespace kinora::formats
