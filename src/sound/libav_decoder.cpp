#include "sound/libav_decoder.h"

#include <algorithm>

namespace kinora::sound {

LibavDecoder::LibavDecoder(const container::Track& track)
    : decoder_(open_decoder(track)), frame_(av_frame_alloc()), packet_(av_packet_alloc()) {}

std::vector<float> LibavDecoder::decode(const container::Payload& packet) {
  std::vector<float> out;
  if (packet.bytes.empty()) return out; // else it would end the track
  libav::fill(*packet_, packet.bytes);
  const int sent = avcodec_send_packet(decoder_.get(), packet_.get());
  av_packet_unref(packet_.get());
  if (sent < 0) return out;
  while (avcodec_receive_frame(decoder_.get(), frame_.get()) >= 0)
    if (fit_resampler()) append(out);
  return out;
}

/// One channel is played on both sides as loud as it is.
bool LibavDecoder::fit_resampler() {
  const int channels = frame_->ch_layout.nb_channels;
  if (resampler_ && format_ == frame_->format && rate_ == frame_->sample_rate && channels_ == channels) return true;
  AVChannelLayout played{};
  av_channel_layout_default(&played, std::min(channels, kPlayedChannels));
  SwrContext* resampler = nullptr;
  int result = swr_alloc_set_opts2(&resampler, &played, AV_SAMPLE_FMT_FLT, kPlayedRate, &frame_->ch_layout,
                                   static_cast<AVSampleFormat>(frame_->format), frame_->sample_rate, 0, nullptr);
  resampler_.reset(resampler);
  if (result >= 0) result = swr_init(resampler_.get());
  format_ = frame_->format;
  rate_ = frame_->sample_rate;
  channels_ = channels;
  if (result < 0) resampler_.reset();
  return resampler_ != nullptr;
}

void LibavDecoder::append(std::vector<float>& out) {
  const int room = swr_get_out_samples(resampler_.get(), frame_->nb_samples);
  if (room <= 0) return;
  const auto played = static_cast<std::size_t>(std::min(channels_, kPlayedChannels));
  std::vector<float> samples(static_cast<std::size_t>(room) * played);
  auto* to = reinterpret_cast<std::uint8_t*>(samples.data());
  const auto** from = const_cast<const std::uint8_t**>(frame_->extended_data);
  const int count = swr_convert(resampler_.get(), &to, room, from, frame_->nb_samples);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(count, 0)); ++i) {
    out.push_back(samples[i * played]);
    out.push_back(samples[i * played + played - 1]);
  }
}

} // namespace kinora::sound
