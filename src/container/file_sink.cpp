#include "container/file_sink.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::container {

FileSink::FileSink(std::filesystem::path path) : path_(std::move(path)), file_(std::fopen(path_.c_str(), "wb")) {
  if (file_ == nullptr) fail("cannot be created");
}

FileSink::~FileSink() {
  if (file_ != nullptr) std::fclose(file_); // given up half-way: the error that led here is already on its way
}

std::uint32_t FileSink::read(void* /*buffer*/, std::size_t /*size*/) { fail("cannot be read while it is written"); }

void FileSink::setFilePointer(std::int64_t offset, libebml::seek_mode mode) {
  if (mode != libebml::seek_beginning) offset += static_cast<std::int64_t>(position_);
  if (mode == libebml::seek_end || fseeko(file_, static_cast<off_t>(offset), SEEK_SET) != 0) {
    fail("cannot be written in any place but its end");
  }
  position_ = static_cast<std::uint64_t>(offset);
}

std::size_t FileSink::write(const void* buffer, std::size_t size) {
  if (size > 0 && std::fwrite(buffer, 1, size, file_) != size) fail("cannot be written to its end");
  position_ += size;
  return size;
}

void FileSink::close() {
  std::FILE* const file = std::exchange(file_, nullptr);
  if (file != nullptr && std::fclose(file) != 0) fail("cannot be written to its end");
}

void FileSink::fail(const char* what) const {
  throw Error(ErrorCode::kUnwritableOutput, fmt::format("{} {} ({}); choose a folder that is writable and has room",
                                                        path_.string(), what, std::strerror(errno)));
}

} // namespace kinora::container
