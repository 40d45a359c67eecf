#include "common/video_file.h"

#include "core/module.h"

namespace kinora::formats {

static const VideoModule& opened_module() {
  using Entry = const VideoModule* (*)();
  static const VideoModule* const opened =
      reinterpret_cast<Entry>(module_symbol("video", "kinora_functions", "to read videos"))();
  return *opened;
}

VideoDescription describe_video(const std::filesystem::path& path) { return opened_module().describe(path); }

std::unique_ptr<VideoReader> open_video(const std::filesystem::path& path, const VideoStream& stream) {
  return opened_module().open(path, stream);
}

} // namespace kinora::formats
