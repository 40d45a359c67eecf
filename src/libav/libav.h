// FFmpeg's libav* for the modules around them: handles that release themselves, failures as errors, files opened
// safely.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "core/error.h"

namespace kinora::libav {

template <class T, void (*release)(T**)> struct Release {
  void operator()(T* handle) const { release(&handle); }
};
using Input = std::unique_ptr<AVFormatContext, Release<AVFormatContext, avformat_close_input>>;
using Codec = std::unique_ptr<AVCodecContext, Release<AVCodecContext, avcodec_free_context>>;
using Frame = std::unique_ptr<AVFrame, Release<AVFrame, av_frame_free>>;
using Packet = std::unique_ptr<AVPacket, Release<AVPacket, av_packet_free>>;

/// Throws Error(code, "WHAT: libav*'s own sentence") for a result that is an error.
void check(int result, ErrorCode code, const std::string& what);

/// A local file of one of these formats, by libavformat's names with commas between; it cannot make us open another
/// one. Throws Error(kCorruptInput): "PATH: WHAT: …".
Input open_file(const std::filesystem::path& path, const char* formats, const std::string& what);

/// Not opened yet; libav* prints nothing from here on, for failures come back as return values. Throws
/// Error(kMissingComponent, missing) without `codec`.
Codec make_codec(const AVCodec* codec, const std::string& missing);

/// What the container keeps of a codec (Matroska's CodecPrivate), for a decoder. Throws Error(kFailure) without memory.
void set_private_data(AVCodecContext& decoder, std::span<const std::byte> bytes);

/// `bytes` as a packet of libav*'s own. Throws Error(kFailure) without memory.
void fill(AVPacket& packet, std::span<const std::byte> bytes);

} // namespace kinora::libav
