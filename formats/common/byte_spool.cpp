#include "common/byte_spool.h"

#include <cerrno>
#include <cstring>

#include "core/error.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kInMemory = std::size_t{16} << 20;
constexpr std::size_t kPiece = std::size_t{1} << 20;

} // namespace

void ByteSpool::fail() const {
  throw Error(ErrorCode::kUnwritableOutput, beside_.string() + ": cannot be written: " + std::strerror(errno));
}

void ByteSpool::spool() {
  if (!file_) {
    const fs::path path = beside_.string() + ".spool";
    file_.reset(std::fopen(path.c_str(), "w+bx"));
    if (!file_) fail();
    std::error_code ignored;
    fs::remove(path, ignored);
  }
  if (std::fwrite(waiting_.data(), 1, waiting_.size(), file_.get()) != waiting_.size()) fail();
  spooled_ += waiting_.size();
  waiting_.clear();
}

void ByteSpool::append(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  if (waiting_.size() > kInMemory) spool();
}

void ByteSpool::pad(std::size_t alignment) {
  waiting_.resize(waiting_.size() + (alignment - size() % alignment) % alignment);
}

void ByteSpool::read(const std::function<void(std::span<const std::byte>)>& take) {
  if (file_) {
    if (std::fflush(file_.get()) != 0) fail();
    std::rewind(file_.get());
    std::vector<std::byte> piece(kPiece);
    for (std::size_t left = spooled_; left > 0;) {
      const std::size_t got = std::fread(piece.data(), 1, std::min(left, piece.size()), file_.get());
      if (got == 0) fail();
      take(std::span(piece).first(got));
      left -= got;
    }
  }
  take(waiting_);
}

} // namespace kinora::formats
