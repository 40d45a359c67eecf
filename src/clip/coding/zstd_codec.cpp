#include "clip/coding/zstd_codec.h"

#include <fmt/format.h>
#include <zstd.h>

#include "core/error.h"

namespace kinora::clip {

namespace {
constexpr int kLevel = 19; // a field is compressed once and read often
}

Bytes compress(std::span<const std::byte> bytes) {
  Bytes frame(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compress(frame.data(), frame.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0) {
    throw Error(ErrorCode::kFailure,
                fmt::format("zstd cannot compress {} bytes: {}", bytes.size(), ZSTD_getErrorName(size)));
  }
  frame.resize(size);
  return frame;
}

Bytes decompress(std::span<const std::byte> frame, std::size_t size, const std::string& location) {
  const auto reject = [&location](const std::string& why) {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: compressed data {}", location, why));
  };
  const unsigned long long announced = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (announced != size) reject(fmt::format("does not hold the {} bytes that it should", size));
  if (ZSTD_findFrameCompressedSize(frame.data(), frame.size()) != frame.size()) reject("is not one whole zstd frame");
  Bytes bytes(size);
  const std::size_t got = ZSTD_decompress(bytes.data(), bytes.size(), frame.data(), frame.size());
  if (got != size) reject("is damaged");
  return bytes;
}

std::uint64_t decompressed_size(std::span<const std::byte> frame, const std::string& location) {
  const unsigned long long size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: compressed data does not say how large it is", location));
  }
  return size;
}

} // namespace kinora::clip
