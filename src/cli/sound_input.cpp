#include "cli/sound_input.h"

#include <cmath>

#include "cli/clip_input.h"
#include "sound/plugin_sound.h"
#include "sound/sound_codec.h"

namespace kinora::cli {
namespace {

class CaptureSound final : public sound::SoundSource {
public:
  CaptureSound(host::FrameReader& reader, const KinoraSound& sound) : reader_(reader), track_(sound::track_of(sound)) {}
  const container::Track& track() const override { return track_; }
  bool next(container::Payload& packet) override {
    const std::optional<KinoraSoundPacket> given = reader_.next_sound();
    if (given) packet = sound::payload_of(*given, reader_.info().start_time);
    return given.has_value();
  }

private:
  host::FrameReader& reader_;
  container::Track track_;
};

} // namespace

void add_audio_option(CLI::App& command, std::filesystem::path& file) {
  command
      .add_option("--audio", file,
                  "Take the sound from this file, which begins with the capture, instead of the capture's")
      ->type_name("FILE");
}

std::unique_ptr<sound::SoundSource> open_sound_of(host::FrameReader& reader, const std::filesystem::path& file) {
  if (!file.empty()) {
    require_input(file);
    return sound::open_sound(file);
  }
  const std::optional<KinoraSound> sound = reader.sound();
  return sound ? std::make_unique<CaptureSound>(reader, *sound) : nullptr;
}

std::int64_t nanoseconds_of(double time, const KinoraCaptureInfo& info) {
  const double ns = (time - info.start_time) * 1e9;
  return std::abs(ns) < 9e18 ? std::llround(ns) : 0;
}

} // namespace kinora::cli
