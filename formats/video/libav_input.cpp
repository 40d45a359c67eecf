#include "video/libav_input.h"

namespace kinora::formats {

double time_of(std::int64_t timestamp, const AVStream& stream) {
  return static_cast<double>(timestamp) * av_q2d(stream.time_base);
}

libav::Input open_input(const std::filesystem::path& path) {
  constexpr std::size_t kMaxBlock = std::size_t{192} << 20; // a picture of 16 bits of 8192x8192; else a size is absurd
  av_max_alloc(kMaxBlock);
  return libav::open_file(path, "matroska,mov,avi", "not a video that can be read");
}

} // namespace kinora::formats
