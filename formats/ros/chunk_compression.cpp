#include "ros/chunk_compression.h"

#include <limits>
#include <memory>

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include "core/error.h"

namespace kinora::formats {
namespace {

/// Fills `out` as far as the bytes go. Returns how much that is, and whether the stream ends there.
struct Unpacked {
  std::size_t bytes = 0;
  bool complete = false;
};

Unpacked unpack_lz4(std::span<const std::byte> bytes, std::span<std::byte> out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) return {};
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> owned(context, &LZ4F_freeDecompressionContext);
  Unpacked result;
  for (std::size_t used = 0; used < bytes.size() && !result.complete;) {
    std::size_t written = out.size() - result.bytes;
    std::size_t taken = bytes.size() - used;
    const std::size_t hint =
        LZ4F_decompress(context, out.data() + result.bytes, &written, bytes.data() + used, &taken, nullptr);
    if (LZ4F_isError(hint) != 0 || (written == 0 && taken == 0)) return result;
    result.bytes += written;
    used += taken;
    result.complete = hint == 0;
  }
  return result;
}

Unpacked unpack_bz2(std::span<const std::byte> bytes, std::span<std::byte> out) {
  constexpr std::size_t kMax = std::numeric_limits<unsigned>::max();
  if (bytes.size() > kMax || out.size() > kMax) return {};
  auto size = static_cast<unsigned>(out.size());
  const int result = BZ2_bzBuffToBuffDecompress(
      reinterpret_cast<char*>(out.data()), &size,
      const_cast<char*>(reinterpret_cast<const char*>(bytes.data())), // NOLINT: the library only reads
      static_cast<unsigned>(bytes.size()), 0, 0);
  return {size, result == BZ_OK};
}

Unpacked unpack_zstd(std::span<const std::byte> bytes, std::span<std::byte> out) {
  const std::size_t size = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  return ZSTD_isError(size) != 0 ? Unpacked{} : Unpacked{size, true};
}

} // namespace

std::vector<std::byte> unpack_chunk(const std::string& compression, std::span<const std::byte> bytes,
                                    std::uint64_t unpacked_bytes, const std::string& source) {
  const auto fail = [&](const std::string& problem) { throw Error(ErrorCode::kCorruptInput, source + ": " + problem); };
  const std::uint64_t limit = (std::uint64_t{64} << 20) + std::uint64_t{256} * bytes.size();
  if (unpacked_bytes > limit) fail("is said to unpack to far more than so few bytes hold");
  std::vector<std::byte> out(static_cast<std::size_t>(unpacked_bytes));
  Unpacked result;
  if (compression == "lz4")
    result = unpack_lz4(bytes, out);
  else if (compression == "bz2")
    result = unpack_bz2(bytes, out);
  else if (compression == "zstd")
    result = unpack_zstd(bytes, out);
  else if (compression.empty() || compression == "none")
    return {bytes.begin(), bytes.end()};
  else
    fail("is compressed in an unknown way (" + compression + ")");
  if (!result.complete || result.bytes != out.size()) fail("cannot be unpacked; the file is damaged");
  return out;
}

} // namespace kinora::formats
