#include "ros/rvl.h"

#include <algorithm>
#include <cstdint>

#include "common/byte_reader.h"

namespace kinora::formats {
namespace {

constexpr std::uint32_t kMaxSide = 16384;
constexpr std::size_t kMaxPixels = std::size_t{1} << 24; // a few bytes may stand for any number of zeros

/// Numbers of any length out of groups of four bits: three of the number, the lowest first, and one that says whether
/// more follow. Eight groups make a word, from its highest bits on.
class Groups {
public:
  explicit Groups(ByteReader& reader) : reader_(reader) {}

  std::uint32_t next() {
    constexpr int kMaxBits = 30;
    std::uint32_t value = 0;
    for (int bits = 0;; bits += 3) {
      if (bits > kMaxBits) reader_.fail("the packed depth is damaged");
      const std::uint32_t group = next_group();
      value |= (group & 7U) << bits;
      if ((group & 8U) == 0) return value;
    }
  }

private:
  std::uint32_t next_group() {
    if (left_ == 0) {
      word_ = reader_.number<std::uint32_t>();
      left_ = 8;
    }
    --left_;
    return word_ >> (4 * left_) & 15U;
  }

  ByteReader& reader_;
  std::uint32_t word_ = 0;
  unsigned left_ = 0;
};

} // namespace

DepthImage16 unpack_rvl(std::span<const std::byte> bytes, const std::string& source) {
  ByteReader reader(bytes, source);
  const auto width = reader.number<std::uint32_t>();
  const auto height = reader.number<std::uint32_t>();
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide || std::size_t{width} * height > kMaxPixels)
    reader.fail("a packed depth image of " + std::to_string(width) + "x" + std::to_string(height) + " is absurd");
  DepthImage16 image(static_cast<int>(width), static_cast<int>(height), 1, 0);
  Groups groups(reader);
  std::uint16_t* to = image.data();
  std::uint16_t* const end = to + image.pixel_count();
  const auto run = [&] {
    const std::uint32_t count = groups.next();
    if (count > static_cast<std::size_t>(end - to)) reader.fail("the packed depth is damaged");
    return count;
  };
  std::uint16_t last = 0;
  while (to != end) {
    to += run(); // zeros
    for (std::uint32_t left = run(); left > 0; --left) {
      const std::uint32_t folded = groups.next();
      last = static_cast<std::uint16_t>(last + ((folded >> 1) ^ (0U - (folded & 1U))));
      *to++ = last;
    }
  }
  return image;
}

} // namespace kinora::formats
