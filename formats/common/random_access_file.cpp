#include "common/random_access_file.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/error.h"

namespace kinora::formats {

RandomAccessFile::RandomAccessFile(const std::filesystem::path& path)
    : name_(path.string()), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  struct stat status {};
  const bool regular = descriptor_ >= 0 && ::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
  if (regular) {
    size_ = static_cast<std::uint64_t>(status.st_size);
    return;
  }
  if (descriptor_ >= 0) ::close(descriptor_);
  throw Error(ErrorCode::kCorruptInput, name_ + ": not a regular file that can be read");
}

RandomAccessFile::RandomAccessFile(RandomAccessFile&& other) noexcept
    : name_(std::move(other.name_)), descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}

RandomAccessFile::~RandomAccessFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::vector<std::byte> RandomAccessFile::read(std::uint64_t offset, std::uint64_t count) const {
  if (offset > size_ || count > size_ - offset)
    throw Error(ErrorCode::kCorruptInput, name_ + ": ends before byte " + std::to_string(offset) + " + " +
                                              std::to_string(count) + "; it is truncated or damaged");
  std::vector<std::byte> bytes(static_cast<std::size_t>(count));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ::ssize_t got =
        ::pread(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<::off_t>(offset + done));
    if (got <= 0) throw Error(ErrorCode::kCorruptInput, name_ + ": cannot be read: " + std::strerror(errno));
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

} // namespace kinora::formats
