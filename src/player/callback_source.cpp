#include "player/callback_source.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include <fmt/format.h>

#include "player/api_errors.h"

namespace kinora::player {
namespace {

class CallbackSource final : public container::ByteSource {
public:
  CallbackSource(const KinoraPlayerSource& source, uint64_t (*new_size)(void*))
      : read_(source.read), new_size_(new_size), context_(source.context), size_(source.size),
        name_(source.name != nullptr ? source.name : "the clip") {}

  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return size_; }
  bool may_grow() const override { return new_size_ != nullptr; }
  void read(std::uint64_t offset, std::span<std::byte> out) override {
    while (!out.empty()) {
      if (offset < start_ || offset >= start_ + filled_) fetch(offset);
      const auto from = static_cast<std::size_t>(offset - start_);
      const std::size_t count = std::min(out.size(), filled_ - from);
      std::memcpy(out.data(), buffer_.data() + from, count);
      out = out.subspan(count);
      offset += count;
    }
  }
  void refresh() override {
    if (new_size_ == nullptr) return;
    const std::uint64_t size = new_size_(context_);
    if (size < size_) {
      throw Error(ErrorCode::kCorruptInput, fmt::format("{}: has become shorter while it was read", name_));
    }
    size_ = size;
    filled_ = 0;
  }

private:
  static constexpr std::size_t kBlock = 1 << 18;

  void fetch(std::uint64_t offset) {
    filled_ = 0;
    if (offset >= size_) misused(fmt::format("{}: byte {} lies behind its end", name_, offset));
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kBlock, size_ - offset));
    buffer_.resize(kBlock);
    if (read_(context_, offset, buffer_.data(), count) == 0) {
      throw Error(ErrorCode::kFailure,
                  fmt::format("{}: bytes {} to {} cannot be fetched", name_, offset, offset + count));
    }
    start_ = offset;
    filled_ = count;
  }

  int (*read_)(void*, uint64_t, void*, size_t);
  uint64_t (*new_size_)(void*);
  void* context_;
  std::uint64_t size_;
  std::string name_;
  std::vector<std::byte> buffer_;
  std::uint64_t start_ = 0;
  std::size_t filled_ = 0;
};

} // namespace

std::unique_ptr<container::ByteSource> callback_source(const KinoraPlayerSource* source) {
  require_size(source, "KinoraPlayerSource", offsetof(KinoraPlayerSource, new_size));
  if (source->read == nullptr) misused("KinoraPlayerSource.read is NULL");
  const bool has_new_size = source->struct_size >= sizeof(KinoraPlayerSource);
  return std::make_unique<CallbackSource>(*source, has_new_size ? source->new_size : nullptr);
}

} // namespace kinora::player
