#include "sound/libav.h"

namespace kinora::sound {
namespace {

struct NamedCodec {
  AVCodecID codec;
  std::string_view id;
  int bits; // 0: not told apart by it
};

// Source: RFC 9559's registry of codecs (draft-ietf-cellar-codec).
constexpr NamedCodec kCodecs[] = {
    {AV_CODEC_ID_OPUS, "A_OPUS", 0},
    {AV_CODEC_ID_VORBIS, "A_VORBIS", 0},
    {AV_CODEC_ID_AAC, "A_AAC", 0},
    {AV_CODEC_ID_MP3, "A_MPEG/L3", 0},
    {AV_CODEC_ID_FLAC, "A_FLAC", 0},
    {AV_CODEC_ID_PCM_U8, "A_PCM/INT/LIT", 8},
    {AV_CODEC_ID_PCM_S16LE, "A_PCM/INT/LIT", 16},
    {AV_CODEC_ID_PCM_S24LE, "A_PCM/INT/LIT", 24},
    {AV_CODEC_ID_PCM_S32LE, "A_PCM/INT/LIT", 32},
    {AV_CODEC_ID_PCM_F32LE, "A_PCM/FLOAT/IEEE", 32},
};

// Where the codec has a description of its own, which a file has to bring.
bool needs_private_data(AVCodecID codec) {
  return codec == AV_CODEC_ID_OPUS || codec == AV_CODEC_ID_VORBIS || codec == AV_CODEC_ID_AAC ||
         codec == AV_CODEC_ID_FLAC;
}

libav::Codec started(libav::Codec context) {
  context->thread_count = 1;
  libav::check(avcodec_open2(context.get(), context->codec, nullptr), ErrorCode::kCorruptInput,
               "sound cannot be decoded");
  return context;
}

libav::Codec context_for(AVCodecID id) {
  return libav::make_codec(avcodec_find_decoder(id), "FFmpeg was built without the codec of this sound");
}

} // namespace

std::string codec_id_of(const AVCodecParameters& parameters) {
  for (const NamedCodec& named : kCodecs)
    if (named.codec == parameters.codec_id && (parameters.extradata_size > 0 || !needs_private_data(named.codec)))
      return std::string(named.id);
  return {};
}

container::Bytes private_data_of(const AVCodecParameters& parameters) {
  if (!needs_private_data(parameters.codec_id)) return {};
  const auto* data = reinterpret_cast<const std::byte*>(parameters.extradata);
  container::Bytes bytes(data, data + parameters.extradata_size);
  constexpr int kStreamInfo = 34;
  if (parameters.codec_id == AV_CODEC_ID_FLAC && parameters.extradata_size == kStreamInfo) {
    // Matroska wants the file's beginning: its mark, and this last block of metadata with its header.
    constexpr unsigned char kBeginning[] = {'f', 'L', 'a', 'C', 0x80, 0, 0, kStreamInfo};
    const auto beginning = std::as_bytes(std::span(kBeginning));
    bytes.insert(bytes.begin(), beginning.begin(), beginning.end());
  }
  return bytes;
}

libav::Codec open_decoder(const AVCodecParameters& parameters) {
  libav::Codec context = context_for(parameters.codec_id);
  libav::check(avcodec_parameters_to_context(context.get(), &parameters), ErrorCode::kCorruptInput,
               "sound cannot be decoded");
  return started(std::move(context));
}

libav::Codec open_decoder(const container::Track& track) {
  const container::MediaFormat media = track.media.value_or(container::MediaFormat{});
  for (const NamedCodec& named : kCodecs) {
    if (named.id != track.codec || (named.bits != 0 && named.bits != media.bits)) continue;
    libav::Codec context = context_for(named.codec);
    context->sample_rate = media.sampling_rate;
    av_channel_layout_default(&context->ch_layout, media.channels);
    if (!track.private_data.empty()) libav::set_private_data(*context, track.private_data);
    return started(std::move(context));
  }
  throw Error(ErrorCode::kCorruptInput,
              std::string("sound of the codec ").append(track.codec).append(" cannot be decoded"));
}

} // namespace kinora::sound
