#include "sound/sound_codec.h"

#include <algorithm>
#include <string_view>

#include "core/module.h"

namespace kinora::sound {
namespace {

const SoundModule& opened_module() {
  using Entry = const SoundModule* (*)();
  static const SoundModule* const opened =
      reinterpret_cast<Entry>(module_symbol("sound", "kinora_functions", "to read and play sound"))();
  return *opened;
}

bool is_compressed(std::string_view codec) {
  constexpr std::string_view kCompressed[] = {"A_OPUS", "A_AAC", "A_MPEG/L3", "A_VORBIS"};
  return std::find(std::begin(kCompressed), std::end(kCompressed), codec) != std::end(kCompressed);
}

} // namespace

std::unique_ptr<SoundSource> open_sound(const std::filesystem::path& path) { return opened_module().open(path); }

container::Sound compact(container::Sound sound) {
  if (!is_compressed(sound.track.codec)) return opened_module().to_opus(sound);
  std::erase_if(sound.packets, [](const container::Payload& packet) { return packet.time_ns < 0; });
  return sound;
}

std::unique_ptr<SoundDecoder> make_sound_decoder(const container::Track& track) {
  return opened_module().make_decoder(track);
}

} // namespace kinora::sound
