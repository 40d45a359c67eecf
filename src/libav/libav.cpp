#include "libav/libav.h"

#include <cstring>

namespace kinora::libav {

void check(int result, ErrorCode code, const std::string& what) {
  if (result >= 0) return;
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(result, text, sizeof text);
  throw Error(code, std::string(what).append(": ").append(text));
}

Input open_file(const std::filesystem::path& path, const char* formats, const std::string& what) {
  av_log_set_level(AV_LOG_QUIET); // a library does not print; failures come back as return values
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  av_dict_set(&options, "format_whitelist", formats, 0);
  AVFormatContext* context = nullptr;
  int result = avformat_open_input(&context, ("file:" + path.string()).c_str(), nullptr, &options);
  av_dict_free(&options);
  Input input(context);
  if (result >= 0) result = avformat_find_stream_info(input.get(), nullptr);
  const std::string problem = path.string() + ": " + what;
  if (result == AVERROR(ENOMEM)) throw Error(ErrorCode::kCorruptInput, problem + ": a size in it is absurd");
  check(result, ErrorCode::kCorruptInput, problem);
  return input;
}

Codec make_codec(const AVCodec* codec, const std::string& missing) {
  if (codec == nullptr) throw Error(ErrorCode::kMissingComponent, missing);
  av_log_set_level(AV_LOG_QUIET);
  return Codec(avcodec_alloc_context3(codec));
}

void set_private_data(AVCodecContext& decoder, std::span<const std::byte> bytes) {
  decoder.extradata = static_cast<std::uint8_t*>(av_mallocz(bytes.size() + AV_INPUT_BUFFER_PADDING_SIZE));
  if (decoder.extradata == nullptr) throw Error(ErrorCode::kFailure, "the description of a track has no room");
  std::memcpy(decoder.extradata, bytes.data(), bytes.size());
  decoder.extradata_size = static_cast<int>(bytes.size());
}

void fill(AVPacket& packet, std::span<const std::byte> bytes) {
  check(av_new_packet(&packet, static_cast<int>(bytes.size())), ErrorCode::kFailure, "a packet has no room");
  std::memcpy(packet.data, bytes.data(), bytes.size());
}

} // namespace kinora::libav
