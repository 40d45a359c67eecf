// The first sound track of a file that libavformat takes apart.
#pragma once

#include <filesystem>
#include <limits>
#include <string>

#include "sound/libav.h"
#include "sound/sound_codec.h"

namespace kinora::sound {

/// See open_sound.
class LibavSource final : public SoundSource {
public:
  explicit LibavSource(const std::filesystem::path& path);
  const container::Track& track() const override { return track_; }
  bool next(container::Payload& packet) override;

private:
  void decode_to_samples();
  std::int64_t skipped_samples(const AVPacket& first) const;
  std::int64_t time_ns(std::int64_t timestamp);
  bool read_packet();
  bool next_packet(container::Payload& packet);
  bool next_samples(container::Payload& packet);

  std::string name_;
  libav::Input input_;
  const AVStream* stream_ = nullptr;
  container::Track track_;
  libav::Packet packet_;
  libav::Frame frame_;
  libav::Codec decoder_; ///< none: packets are given as they are
  Resampler resampler_;
  bool first_is_read_ = false; ///< packet_ holds the first one, which was not given yet
  std::int64_t shift_ns_ = 0;  ///< from the file's times to ours
  bool drained_ = false;       ///< the decoder was told that there are no more packets
  std::int64_t last_time_ns_ = std::numeric_limits<std::int64_t>::min();
};

} // namespace kinora::sound
