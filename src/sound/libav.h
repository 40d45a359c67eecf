// What the module sound does with libav* (libav/libav.h) in several places.
#pragma once

#include <string>

#include "container/sound.h"
#include "libav/libav.h"

extern "C" {
#include <libswresample/swresample.h>
}

namespace kinora::sound {

using Resampler = std::unique_ptr<SwrContext, libav::Release<SwrContext, swr_free>>;

inline constexpr AVRational kNanosecond = {1, 1'000'000'000};

/// Matroska's CodecID for what libav* calls so; empty if none that is kept as it is.
std::string codec_id_of(const AVCodecParameters& parameters);
/// CodecPrivate of a stream whose codec has a CodecID.
container::Bytes private_data_of(const AVCodecParameters& parameters);

/// A decoder of a file's stream, or of a track. Throws Error(kCorruptInput).
libav::Codec open_decoder(const AVCodecParameters& parameters);
libav::Codec open_decoder(const container::Track& track);

} // namespace kinora::sound
