#include "video/libav_input.h"

#include "core/error.h"

namespace kinora::formats {

std::string libav_text(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

double time_of(std::int64_t timestamp, const AVStream& stream) {
  return static_cast<double>(timestamp) * av_q2d(stream.time_base);
}

AvInput open_input(const std::filesystem::path& path) {
  constexpr std::size_t kMaxBlock = std::size_t{192} << 20; // a picture of 16 bits of 8192x8192; else a size is absurd
  av_max_alloc(kMaxBlock);
  av_log_set_level(AV_LOG_QUIET); // a library does not print; failures come back as return values
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0); // a file cannot make us open another one
  av_dict_set(&options, "format_whitelist", "matroska,mov,avi", 0);
  AVFormatContext* context = nullptr;
  int result = avformat_open_input(&context, ("file:" + path.string()).c_str(), nullptr, &options);
  av_dict_free(&options);
  AvInput input(context);
  if (result >= 0) result = avformat_find_stream_info(input.get(), nullptr);
  if (result < 0)
    throw Error(ErrorCode::kCorruptInput,
                path.string() + ": not a video that can be read: " +
                    (result == AVERROR(ENOMEM) ? "a size in it is absurd" : libav_text(result)));
  return input;
}

} // namespace kinora::formats
