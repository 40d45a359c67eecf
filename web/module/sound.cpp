// A clip's sound as its file has it, for the browser's decoders. Numbers as in kinora_module.c.
#include <cstddef>
#include <cstdint>

#include "player/player_handle.h"

extern "C" {

/// Number of packets, or 0; `codec` Matroska's name of the codec, `setup` and `setup_bytes` its private data, `numbers`
/// samples a second, channels, seconds that its decoder delays.
std::size_t module_sound(const KinoraPlayer* player, const char** codec, const std::byte** setup,
                         std::size_t* setup_bytes, double numbers[3]) {
  const auto now = player->player(); // the handle keeps it
  const auto& sound = now->clip().sound;
  if (!sound || !sound->track.media) return 0;
  *codec = sound->track.codec.c_str();
  *setup = sound->track.private_data.data();
  *setup_bytes = sound->track.private_data.size();
  numbers[0] = sound->track.media->sampling_rate;
  numbers[1] = sound->track.media->channels;
  numbers[2] = 1e-9 * static_cast<double>(sound->track.media->delay_ns);
  return sound->packets.size();
}

/// Its size; `data` its bytes, `seconds` its time as that of frames.
std::size_t module_sound_packet(const KinoraPlayer* player, std::size_t packet, const std::byte** data,
                                double* seconds) {
  const auto now = player->player();
  const auto& stored = now->clip().sound->packets[packet];
  *data = stored.bytes.data();
  *seconds = 1e-9 * static_cast<double>(stored.time_ns);
  return stored.bytes.size();
}

} // extern "C"
