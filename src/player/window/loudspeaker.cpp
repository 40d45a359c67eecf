#include "player/window/loudspeaker.h"

#include "core/module.h"

namespace kinora::player::window {

std::unique_ptr<Loudspeaker> open_loudspeaker() {
  using Entry = const LoudspeakerModule* (*)();
  static const LoudspeakerModule* const opened =
      reinterpret_cast<Entry>(module_symbol("loudspeaker", "kinora_functions", "to play sound"))();
  return opened->open();
}

} // namespace kinora::player::window
