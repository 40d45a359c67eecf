#include "sound/sound_source.h"

namespace kinora::sound {

container::Sound excerpt(SoundSource& source, std::int64_t begin_ns, std::int64_t end_ns) {
  container::Sound sound{source.track(), {}};
  SoundFeed feed(source);
  container::Payload packet;
  while (feed.next_until(end_ns, packet)) {
    packet.time_ns -= begin_ns;
    if (packet.time_ns <= 0) sound.packets.clear();
    sound.packets.push_back(std::move(packet));
  }
  return sound;
}

} // namespace kinora::sound
