// The module video: libav* for all formats that read videos.
#include "video/libav_video_reader.h"
#include "video/video_description.h"

namespace kinora::formats {

static const VideoModule kModule = {
    read_description, [](const std::filesystem::path& path, const VideoStream& stream) -> std::unique_ptr<VideoReader> {
      return std::make_unique<LibavVideoReader>(path, stream);
    }};

} // namespace kinora::formats

extern "C" const kinora::formats::VideoModule* kinora_functions() { return &kinora::formats::kModule; }
