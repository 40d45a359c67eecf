#include "container/byte_source.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::container {

namespace {
constexpr std::size_t kBufferBytes = 1 << 16;
}

FileSource::FileSource(const std::filesystem::path& path) : name_(path.string()) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    throw Error(ErrorCode::kNotRecognised, fmt::format("{} does not exist; name a Kinora file", name_));
  }
  if (!std::filesystem::is_regular_file(path, error)) {
    throw Error(ErrorCode::kNotRecognised, fmt::format("{} is not a file; name a Kinora file", name_));
  }
  size_ = std::filesystem::file_size(path, error);
  if (!error) file_ = std::fopen(path.c_str(), "rb");
  if (file_ == nullptr) {
    throw Error(ErrorCode::kFailure, fmt::format("{} cannot be opened ({}); look at its permissions", name_,
                                                 error ? error.message() : std::strerror(errno)));
  }
  std::setvbuf(file_, nullptr, _IONBF, 0); // buffered here, where seeking keeps the buffer
}

FileSource::~FileSource() {
  if (file_ != nullptr) std::fclose(file_);
}

void FileSource::read(std::uint64_t offset, std::span<std::byte> out) {
  if (out.size() >= kBufferBytes) {
    read_through(offset, out);
    return;
  }
  if (offset < buffer_offset_ || offset + out.size() > buffer_offset_ + buffer_.size()) {
    buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBufferBytes, size_ - offset)));
    buffer_offset_ = offset;
    read_through(offset, buffer_);
  }
  const auto start = static_cast<std::size_t>(offset - buffer_offset_);
  std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(start), out.size(), out.begin());
}

void FileSource::refresh() {
  buffer_.clear();
  if (fseeko(file_, 0, SEEK_END) != 0) return;
  const auto size = static_cast<std::uint64_t>(ftello(file_));
  if (size < size_) {
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: has become shorter while it was read; somebody else writes to it", name_));
  }
  size_ = size;
}

void FileSource::read_through(std::uint64_t offset, std::span<std::byte> out) {
  if (fseeko(file_, static_cast<off_t>(offset), SEEK_SET) != 0 ||
      std::fread(out.data(), 1, out.size(), file_) != out.size()) {
    buffer_.clear();
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}: bytes {} to {} cannot be read; the file changed or its disk is faulty", name_, offset,
                            offset + out.size()));
  }
}

void MemorySource::read(std::uint64_t offset, std::span<std::byte> out) {
  std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
}

} // namespace kinora::container
