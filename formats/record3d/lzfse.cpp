#include "record3d/lzfse.h"

#include <array>
#include <bit>

#include "common/byte_reader.h"
#include "record3d/lzfse_blocks.h"

namespace kinora::formats {
namespace {

constexpr std::uint32_t magic(char last) {
  return 0x00787662U | static_cast<std::uint32_t>(last) << 24U;
} // "bvx" and one

} // namespace

std::vector<std::byte> unpack_lzfse(std::span<const std::byte> bytes, std::size_t unpacked_bytes,
                                    const std::string& source) {
  ByteReader reader(bytes, source);
  UnpackedBytes out(unpacked_bytes, source);
  for (;;) {
    const auto kind = reader.number<std::uint32_t>();
    if (kind == magic('$')) break;
    if (kind == magic('-'))
      out.append(reader.bytes(reader.number<std::uint32_t>()));
    else if (kind == magic('n'))
      unpack_lzvn_block(reader, out);
    else if (kind == magic('2'))
      unpack_lzfse_block(reader, out);
    else
      reader.fail("is not packed with LZFSE, or is damaged");
  }
  return out.finish();
}

} // namespace kinora::formats
