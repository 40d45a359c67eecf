#include "cli/drawn_pictures.h"

#include <fstream>
#include <iterator>
#include <system_error>

#include <fmt/format.h>

#include "clip/coding/zstd_codec.h"
#include "container/crc32c.h"
#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::cli {
namespace fs = std::filesystem;
namespace {

using container::get;
using container::put;

constexpr std::size_t kHeadBytes = 16; // checksum of the rest, width, height, channels; the pixels follow, compressed

clip::Bytes contents_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

void check(bool written, const fs::path& path) {
  if (!written)
    throw Error(ErrorCode::kUnwritableOutput,
                fmt::format("{} cannot be written; make room, or render without --resume", path.string()));
}

} // namespace

fs::path DrawnPictures::path_of(std::size_t index, std::uint32_t key) const {
  return folder_ / fmt::format("{:06}-{:08x}", index, key);
}

std::optional<ColorImage> DrawnPictures::find(std::size_t index, std::uint32_t key) {
  const fs::path path = path_of(index, key);
  const clip::Bytes bytes = contents_of(path);
  const auto checked = std::span(bytes).subspan(std::min<std::size_t>(bytes.size(), 4));
  if (bytes.size() < kHeadBytes || container::crc32c(checked) != get<std::uint32_t>(bytes, 0)) return std::nullopt;
  constexpr std::int32_t kMaxSide = 16384;
  const auto width = get<std::int32_t>(bytes, 4);
  const auto height = get<std::int32_t>(bytes, 8);
  if (width < 1 || width > kMaxSide || height < 1 || height > kMaxSide || get<std::int32_t>(bytes, 12) != 4)
    return std::nullopt;
  ColorImage picture(width, height, 4);
  const std::size_t size = picture.pixel_count() * static_cast<std::size_t>(picture.channels());
  const clip::Bytes pixels = clip::decompress(std::span(bytes).subspan(kHeadBytes), size, path.string());
  std::memcpy(picture.data(), pixels.data(), size);
  ours_.insert(path);
  return picture;
}

void DrawnPictures::keep(std::size_t index, std::uint32_t key, const ColorImage& picture) {
  const fs::path path = path_of(index, key);
  const std::size_t size = picture.pixel_count() * static_cast<std::size_t>(picture.channels());
  clip::Bytes checked;
  for (const std::int32_t number : {picture.width(), picture.height(), picture.channels()}) put(checked, number);
  const clip::Bytes pixels = clip::compress(std::as_bytes(std::span(picture.data(), size)));
  checked.insert(checked.end(), pixels.begin(), pixels.end());
  clip::Bytes checksum;
  put(checksum, container::crc32c(checked));
  std::error_code ignored;
  fs::create_directory(folder_, ignored);
  ours_.insert(path); // also if it is not whole
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(checksum.data()), static_cast<std::streamsize>(checksum.size()));
  file.write(reinterpret_cast<const char*>(checked.data()), static_cast<std::streamsize>(checked.size()));
  file.close();
  check(file.good(), path);
}

void DrawnPictures::remove() {
  std::error_code ignored;
  for (const fs::path& path : ours_) fs::remove(path, ignored);
  fs::remove(folder_, ignored);
}

} // namespace kinora::cli
