#include "container/file_sink.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::container {

namespace {
constexpr std::size_t kBufferBytes = 1 << 16;
constexpr mode_t kPermissions = 0666; // less what the user's mask takes
} // namespace

FileSink::FileSink(std::filesystem::path path)
    : path_(std::move(path)), file_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kPermissions)) {
  if (file_ < 0) fail("cannot be created");
}

FileSink::~FileSink() {
  if (file_ >= 0) ::close(file_); // given up half-way: the error that led here is already on its way
}

std::uint32_t FileSink::read(void* /*buffer*/, std::size_t /*size*/) { fail("cannot be read while it is written"); }

void FileSink::setFilePointer(std::int64_t offset, libebml::seek_mode mode) {
  drain();
  if (mode != libebml::seek_beginning) offset += static_cast<std::int64_t>(position_);
  if (mode == libebml::seek_end || ::lseek(file_, static_cast<off_t>(offset), SEEK_SET) < 0) {
    fail("cannot be written in any place but its end");
  }
  position_ = static_cast<std::uint64_t>(offset);
}

std::size_t FileSink::write(const void* buffer, std::size_t size) {
  const auto* const bytes = static_cast<const std::byte*>(buffer);
  buffer_.insert(buffer_.end(), bytes, bytes + size);
  position_ += size;
  if (buffer_.size() >= kBufferBytes) drain();
  return size;
}

void FileSink::drain() {
  for (std::size_t done = 0; done < buffer_.size();) {
    const ssize_t count = ::write(file_, buffer_.data() + done, buffer_.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail("cannot be written to its end");
    done += static_cast<std::size_t>(count);
  }
  buffer_.clear();
}

void FileSink::flush(bool durable) {
  drain();
  // Devices have nothing to wait for, and say so.
  if (durable && ::fdatasync(file_) != 0 && errno != EINVAL && errno != EROFS) fail("cannot be brought to the disk");
}

void FileSink::cut(std::uint64_t size) {
  buffer_.clear();
  if (::ftruncate(file_, static_cast<off_t>(size)) != 0 || ::lseek(file_, 0, SEEK_END) < 0) {
    fail("cannot be shortened to what is whole of it");
  }
  position_ = size;
}

void FileSink::close() {
  if (file_ < 0) return;
  drain();
  if (::close(std::exchange(file_, -1)) != 0) fail("cannot be written to its end");
}

void FileSink::fail(const char* what) const {
  throw Error(ErrorCode::kUnwritableOutput, fmt::format("{} {} ({}); choose a folder that is writable and has room",
                                                        path_.string(), what, std::strerror(errno)));
}

} // namespace kinora::container
