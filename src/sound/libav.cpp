#include "sound/libav.h"

#include <cstring>

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

AvCodec started(AvCodec context) {
  context->thread_count = 1;
  check(avcodec_open2(context.get(), context->codec, nullptr), ErrorCode::kCorruptInput, "sound cannot be decoded");
  return context;
}

AvCodec context_for(AVCodecID id) {
  av_log_set_level(AV_LOG_QUIET); // a library does not print; failures come back as return values
  const AVCodec* const codec = avcodec_find_decoder(id);
  if (codec == nullptr) throw Error(ErrorCode::kMissingComponent, "FFmpeg was built without the codec of this sound");
  return AvCodec(avcodec_alloc_context3(codec));
}

} // namespace

void check(int result, ErrorCode code, const std::string& what) {
  if (result >= 0) return;
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(result, text, sizeof text);
  throw Error(code, std::string(what).append(": ").append(text));
}

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

AvCodec open_decoder(const AVCodecParameters& parameters) {
  AvCodec context = context_for(parameters.codec_id);
  check(avcodec_parameters_to_context(context.get(), &parameters), ErrorCode::kCorruptInput, "sound cannot be decoded");
  return started(std::move(context));
}

AvCodec open_decoder(const container::Track& track) {
  const container::MediaFormat media = track.media.value_or(container::MediaFormat{});
  for (const NamedCodec& named : kCodecs) {
    if (named.id != track.codec || (named.bits != 0 && named.bits != media.bits)) continue;
    AvCodec context = context_for(named.codec);
    context->sample_rate = media.sampling_rate;
    av_channel_layout_default(&context->ch_layout, media.channels);
    if (!track.private_data.empty()) {
      const std::size_t size = track.private_data.size();
      context->extradata = static_cast<std::uint8_t*>(av_mallocz(size + AV_INPUT_BUFFER_PADDING_SIZE));
      if (context->extradata == nullptr) throw Error(ErrorCode::kFailure, "the description of sound has no room");
      std::memcpy(context->extradata, track.private_data.data(), size);
      context->extradata_size = static_cast<int>(size);
    }
    return started(std::move(context));
  }
  throw Error(ErrorCode::kCorruptInput,
              std::string("sound of the codec ").append(track.codec).append(" cannot be decoded"));
}

void fill(AVPacket& packet, std::span<const std::byte> bytes) {
  check(av_new_packet(&packet, static_cast<int>(bytes.size())), ErrorCode::kFailure, "sound has no room");
  std::memcpy(packet.data, bytes.data(), bytes.size());
}

} // namespace kinora::sound
