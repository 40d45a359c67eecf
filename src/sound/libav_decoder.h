// Packets of a track to samples, by libavcodec and libswresample.
#pragma once

#include "sound/libav.h"
#include "sound/sound_codec.h"

namespace kinora::sound {

/// See SoundDecoder.
class LibavDecoder final : public SoundDecoder {
public:
  explicit LibavDecoder(const container::Track& track);
  std::vector<float> decode(const container::Payload& packet) override;
  void reset() override { avcodec_flush_buffers(decoder_.get()); }

private:
  bool fit_resampler();
  void append(std::vector<float>& out);

  libav::Codec decoder_;
  libav::Frame frame_;
  libav::Packet packet_;
  Resampler resampler_;
  int format_ = -1; ///< of what the resampler is made for
  int rate_ = 0;
  int channels_ = 0;
};

} // namespace kinora::sound
