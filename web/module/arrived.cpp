// Opening what has come of a clip. Numbers as in kinora_module.c.
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "core/error.h"
#include "player/arrived_clip.h"
#include "player/player_handle.h"

namespace {

std::string sentence; // NOLINT: about the last call; the module has one thread

} // namespace

extern "C" {

/// What is missing, or wrong; empty: nothing.
const char* module_arrived_sentence() { return sentence.c_str(); }

/// A KinoraPlayerStatus. `*player` is null if more has to come before anything can be shown; `*finished` 1 if nothing
/// will follow these bytes. `all`: nothing follows them now.
int module_open_arrived(const std::byte* bytes, std::size_t size, const char* name, int all, KinoraPlayer** player,
                        std::int32_t* finished) {
  *player = nullptr;
  *finished = 0;
  sentence.clear();
  try {
    const std::span there(bytes, size);
    const bool last = all != 0 && kinora::player::state_of(there, name) != kinora::player::FileState::kGrowing;
    kinora::player::ArrivedClip arrived = kinora::player::read_arrived(there, name, last);
    *finished = last ? 1 : 0;
    sentence = std::move(arrived.missing);
    if (arrived.clip) {
      auto now = std::make_shared<const kinora::player::Player>(std::move(*arrived.clip));
      // complete as far as this player goes: what comes later gets another
      *player =
          new KinoraPlayer(kinora::player::ClipSoFar{std::move(now), true, {}, size}); // NOLINT: owned by JavaScript
    }
    return 0;
  } catch (const kinora::Error& error) {
    sentence = error.what();
    return error.exit_code();
  } catch (const std::exception& error) {
    sentence = error.what();
    return 1;
  }
}

} // extern "C"
