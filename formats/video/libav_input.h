// A file that libavformat takes apart.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

namespace kinora::formats {

template <class T, void (*release)(T**)> struct Release {
  void operator()(T* handle) const { release(&handle); }
};
using AvInput = std::unique_ptr<AVFormatContext, Release<AVFormatContext, avformat_close_input>>;
using AvDecoder = std::unique_ptr<AVCodecContext, Release<AVCodecContext, avcodec_free_context>>;
using AvFrame = std::unique_ptr<AVFrame, Release<AVFrame, av_frame_free>>;
using AvPacket = std::unique_ptr<AVPacket, Release<AVPacket, av_packet_free>>;

/// Throws Error(kCorruptInput), naming the path.
AvInput open_input(const std::filesystem::path& path);

/// libav*'s sentence for an error.
std::string libav_text(int error);

/// When a packet's picture is shown, in seconds.
double time_of(std::int64_t timestamp, const AVStream& stream);

} // namespace kinora::formats
