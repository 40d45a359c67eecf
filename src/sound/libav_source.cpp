#include "sound/libav_source.h"

#include <algorithm>
#include <utility>

namespace kinora::sound {
static constexpr const char* kFormats = "wav,flac,ogg,mp3,aac,mov,matroska";

LibavSource::LibavSource(const std::filesystem::path& path)
    : name_(path.string()), input_(libav::open_file(path, kFormats, "not a file of sound that can be read")),
      packet_(av_packet_alloc()), frame_(av_frame_alloc()) {
  const int found = av_find_best_stream(input_.get(), AVMEDIA_TYPE_AUDIO, -1, -1, nullptr, 0);
  if (found < 0) throw Error(ErrorCode::kCorruptInput, name_ + ": holds no sound");
  for (unsigned s = 0; s < input_->nb_streams; ++s)
    if (static_cast<int>(s) != found) input_->streams[s]->discard = AVDISCARD_ALL;
  stream_ = input_->streams[found];
  const AVCodecParameters& parameters = *stream_->codecpar;
  if (parameters.sample_rate < 1 || parameters.ch_layout.nb_channels < 1)
    throw Error(ErrorCode::kCorruptInput, name_ + ": its sound has no rate or no channels");
  track_.id = container::kSoundTrack;
  track_.codec = codec_id_of(parameters);
  track_.media.emplace();
  track_.media->sampling_rate = parameters.sample_rate;
  track_.media->channels = parameters.ch_layout.nb_channels;
  if (track_.codec.empty()) {
    decode_to_samples();
    return;
  }
  track_.private_data = private_data_of(parameters);
  track_.media->bits = parameters.bits_per_raw_sample > 0 ? parameters.bits_per_raw_sample
                                                          : std::max(parameters.bits_per_coded_sample, 0);
  first_is_read_ = read_packet();
  if (!first_is_read_) return;
  track_.media->delay_ns = av_rescale_q(skipped_samples(*packet_), {1, parameters.sample_rate}, kNanosecond);
  // Demuxers put what is not heard before time 0, where its packets' times have no place.
  if (track_.media->delay_ns > 0 && packet_->pts != AV_NOPTS_VALUE && packet_->pts < 0)
    shift_ns_ = -av_rescale_q(packet_->pts, stream_->time_base, kNanosecond);
}

/// At the beginning: decoded, and not heard.
std::int64_t LibavSource::skipped_samples(const AVPacket& first) const {
  const AVCodecParameters& parameters = *stream_->codecpar;
  constexpr int kPreSkip = 10; // byte of Opus's description: RFC 7845, section 5.1, in samples of 48 kHz
  if (parameters.codec_id == AV_CODEC_ID_OPUS && parameters.extradata_size > kPreSkip + 1) {
    const int samples = parameters.extradata[kPreSkip] | parameters.extradata[kPreSkip + 1] << 8;
    return static_cast<std::int64_t>(samples) * parameters.sample_rate / kPlayedRate;
  }
  std::size_t size = 0;
  const std::uint8_t* data = av_packet_get_side_data(&first, AV_PKT_DATA_SKIP_SAMPLES, &size);
  if (data == nullptr || size < sizeof(std::uint32_t)) return 0;
  return data[0] | data[1] << 8 | data[2] << 16; // little endian
}

void LibavSource::decode_to_samples() {
  decoder_ = open_decoder(*stream_->codecpar);
  decoder_->pkt_timebase = stream_->time_base;
  track_.codec = "A_PCM/INT/LIT";
  track_.media->bits = 16;
  SwrContext* resampler = nullptr;
  int result = swr_alloc_set_opts2(&resampler, &decoder_->ch_layout, AV_SAMPLE_FMT_S16, decoder_->sample_rate,
                                   &decoder_->ch_layout, decoder_->sample_fmt, decoder_->sample_rate, 0, nullptr);
  resampler_.reset(resampler);
  if (result >= 0) result = swr_init(resampler_.get());
  libav::check(result, ErrorCode::kCorruptInput, name_ + ": its sound cannot be decoded");
}

std::int64_t LibavSource::time_ns(std::int64_t timestamp) {
  if (timestamp == AV_NOPTS_VALUE) return last_time_ns_;
  const std::int64_t time = av_rescale_q(timestamp, stream_->time_base, kNanosecond) + shift_ns_;
  return last_time_ns_ = std::max(last_time_ns_, time);
}

bool LibavSource::next(container::Payload& packet) { return decoder_ ? next_samples(packet) : next_packet(packet); }

bool LibavSource::read_packet() {
  for (;;) {
    av_packet_unref(packet_.get());
    const int result = av_read_frame(input_.get(), packet_.get());
    if (result == AVERROR_EOF) return false;
    libav::check(result, ErrorCode::kCorruptInput, name_ + ": its sound cannot be read any further");
    if (packet_->stream_index == stream_->index && packet_->size > 0) return true;
  }
}

bool LibavSource::next_packet(container::Payload& packet) {
  if (!std::exchange(first_is_read_, false) && !read_packet()) return false;
  const auto* data = reinterpret_cast<const std::byte*>(packet_->data);
  packet = {track_.id, time_ns(packet_->pts), true, container::Bytes(data, data + packet_->size)};
  return true;
}

bool LibavSource::next_samples(container::Payload& packet) {
  while (avcodec_receive_frame(decoder_.get(), frame_.get()) < 0) {
    if (drained_) return false;
    drained_ = !read_packet();
    avcodec_send_packet(decoder_.get(), drained_ ? nullptr : packet_.get()); // what is damaged gives nothing
  }
  const auto samples = static_cast<std::size_t>(frame_->nb_samples);
  container::Bytes bytes(samples * 2 * static_cast<std::size_t>(track_.media->channels));
  auto* out = reinterpret_cast<std::uint8_t*>(bytes.data());
  const auto** in = const_cast<const std::uint8_t**>(frame_->extended_data);
  libav::check(swr_convert(resampler_.get(), &out, frame_->nb_samples, in, frame_->nb_samples),
               ErrorCode::kCorruptInput, name_ + ": its sound cannot be decoded");
  packet = {track_.id, time_ns(frame_->best_effort_timestamp), true, std::move(bytes)};
  return true;
}

} // namespace kinora::sound
