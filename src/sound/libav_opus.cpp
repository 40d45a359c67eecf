#include "sound/libav_opus.h"

#include <algorithm>
#include <cmath>

#include "sound/libav_decoder.h"

namespace kinora::sound {
namespace {

constexpr int kBitsPerChannel = 64'000; // a second
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kGap = kPlayedRate / 20; // samples; less is a rounded time

/// Left and right in turn, from time 0 on.
std::vector<float> samples_of(const container::Sound& sound) {
  LibavDecoder decoder(sound.track);
  std::vector<float> samples;
  for (const container::Payload& packet : sound.packets) {
    const std::vector<float> decoded = decoder.decode(packet);
    const std::int64_t heard = packet.time_ns - sound.track.media->delay_ns;
    const std::int64_t begin = av_rescale(heard, kPlayedRate, kSecond);
    const auto written = static_cast<std::int64_t>(samples.size()) / kPlayedChannels;
    if (begin > written + kGap) samples.resize(static_cast<std::size_t>(begin * kPlayedChannels));
    const std::int64_t early = samples.empty() ? std::max<std::int64_t>(-begin * kPlayedChannels, 0) : 0;
    const auto skipped = std::min<std::ptrdiff_t>(early, static_cast<std::ptrdiff_t>(decoded.size()));
    samples.insert(samples.end(), decoded.begin() + skipped, decoded.end());
  }
  return samples;
}

libav::Codec open_encoder(int channels) {
  libav::Codec encoder = libav::make_codec(avcodec_find_encoder_by_name("libopus"),
                                           "FFmpeg was built without libopus; give sound that is Opus, AAC or MP3");
  encoder->sample_rate = kPlayedRate;
  encoder->sample_fmt = AV_SAMPLE_FMT_FLT;
  encoder->bit_rate = kBitsPerChannel * static_cast<std::int64_t>(channels);
  encoder->flags |= AV_CODEC_FLAG_BITEXACT;
  av_channel_layout_default(&encoder->ch_layout, channels);
  libav::check(avcodec_open2(encoder.get(), encoder->codec, nullptr), ErrorCode::kFailure, "Opus cannot be started");
  return encoder;
}

} // namespace

container::Sound to_opus(const container::Sound& sound) {
  const int channels = std::min(sound.track.media->channels, kPlayedChannels);
  const std::vector<float> samples = samples_of(sound);
  const libav::Codec encoder = open_encoder(channels);
  container::Sound out{sound.track, {}};
  out.track.codec = "A_OPUS";
  const auto* description = reinterpret_cast<const std::byte*>(encoder->extradata);
  out.track.private_data.assign(description, description + encoder->extradata_size);
  out.track.media = container::MediaFormat{};
  out.track.media->sampling_rate = kPlayedRate;
  out.track.media->channels = channels;
  out.track.media->delay_ns = av_rescale(encoder->initial_padding, kSecond, kPlayedRate);

  const libav::Frame frame(av_frame_alloc());
  const libav::Packet packet(av_packet_alloc());
  frame->format = encoder->sample_fmt;
  frame->nb_samples = encoder->frame_size;
  libav::check(av_channel_layout_copy(&frame->ch_layout, &encoder->ch_layout), ErrorCode::kFailure,
               "sound has no room");
  libav::check(av_frame_get_buffer(frame.get(), 0), ErrorCode::kFailure, "sound has no room");
  const auto size = static_cast<std::size_t>(encoder->frame_size);
  const auto receive = [&] {
    while (avcodec_receive_packet(encoder.get(), packet.get()) >= 0) {
      const auto* data = reinterpret_cast<const std::byte*>(packet->data);
      const auto number = static_cast<std::int64_t>(out.packets.size());
      out.packets.push_back({out.track.id, av_rescale(number * encoder->frame_size, kSecond, kPlayedRate), true,
                             container::Bytes(data, data + packet->size)});
      av_packet_unref(packet.get());
    }
  };
  const std::size_t count = samples.size() / kPlayedChannels;
  for (std::size_t begin = 0; begin < count; begin += size) {
    libav::check(av_frame_make_writable(frame.get()), ErrorCode::kFailure, "sound has no room");
    auto* to = reinterpret_cast<float*>(frame->data[0]);
    for (std::size_t i = 0; i < size; ++i)
      for (int c = 0; c < channels; ++c)
        *to++ = begin + i < count ? samples[(begin + i) * kPlayedChannels + static_cast<std::size_t>(c)] : 0.0F;
    frame->pts = static_cast<std::int64_t>(begin);
    libav::check(avcodec_send_frame(encoder.get(), frame.get()), ErrorCode::kFailure, "Opus cannot encode");
    receive();
  }
  avcodec_send_frame(encoder.get(), nullptr);
  receive();
  return out;
}

} // namespace kinora::sound
