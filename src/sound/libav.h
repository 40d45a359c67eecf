// libav*'s handles for the module sound.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswresample/swresample.h>
}

#include "container/sound.h"
#include "core/error.h"

namespace kinora::sound {

template <class T, void (*release)(T**)> struct Release {
  void operator()(T* handle) const { release(&handle); }
};
using AvInput = std::unique_ptr<AVFormatContext, Release<AVFormatContext, avformat_close_input>>;
using AvCodec = std::unique_ptr<AVCodecContext, Release<AVCodecContext, avcodec_free_context>>;
using AvFrame = std::unique_ptr<AVFrame, Release<AVFrame, av_frame_free>>;
using AvPacket = std::unique_ptr<AVPacket, Release<AVPacket, av_packet_free>>;
using AvResampler = std::unique_ptr<SwrContext, Release<SwrContext, swr_free>>;

inline constexpr AVRational kNanosecond = {1, 1'000'000'000};

/// Throws Error for a result that is one of libav*'s errors.
void check(int result, ErrorCode code, const std::string& what);

/// Matroska's CodecID for what libav* calls so; empty if none that is kept as it is.
std::string codec_id_of(const AVCodecParameters& parameters);
/// CodecPrivate of a stream whose codec has a CodecID.
container::Bytes private_data_of(const AVCodecParameters& parameters);

/// A decoder of a file's stream, or of a track. Throws Error(kCorruptInput).
AvCodec open_decoder(const AVCodecParameters& parameters);
AvCodec open_decoder(const container::Track& track);

/// `bytes` as a packet of libav*'s own.
void fill(AVPacket& packet, std::span<const std::byte> bytes);

} // namespace kinora::sound
