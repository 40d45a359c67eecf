// Opening what has come of a clip. Numbers as in kinora_module.c.
#include <algorithm>
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

using kinora::player::ArrivedClip;
using kinora::player::Readiness;

// About the last call; the module has one thread.
std::string sentence; // NOLINT
ArrivedClip arrived;  // NOLINT: without its clip, which the player has

} // namespace

extern "C" {

/// What is missing, or wrong; empty: nothing.
const char* module_arrived_sentence() { return sentence.c_str(); }

/// Number of frames that the file says it has; of each, unless the arrays are null, its seconds and whether it has
/// come.
std::size_t module_arrived_frames(double* seconds, std::uint8_t* there) {
  if (seconds != nullptr) std::copy(arrived.times.begin(), arrived.times.end(), seconds);
  if (there != nullptr) std::copy(arrived.there.begin(), arrived.there.end(), there);
  return arrived.times.size();
}

/// A KinoraPlayerStatus. `*player` is null if more has to come before anything can be shown; `*finished` 1 if nothing
/// will follow these bytes. `all`: nothing follows them now. `first_look`: made ready as soon as can be, and to be
/// opened again.
int module_open_arrived(const std::byte* bytes, std::size_t size, const char* name, int all, int first_look,
                        KinoraPlayer** player, std::int32_t* finished) {
  *player = nullptr;
  *finished = 0;
  sentence.clear();
  arrived = {};
  try {
    const std::span there(bytes, size);
    const bool last = all != 0 && kinora::player::state_of(there, name) != kinora::player::FileState::kGrowing;
    arrived = kinora::player::read_arrived(there, name, last);
    *finished = last ? 1 : 0;
    sentence = std::move(arrived.missing);
    if (arrived.clip) {
      const auto readiness = first_look != 0 ? Readiness::kFirstLook : Readiness::kWhole;
      auto now = std::make_shared<const kinora::player::Player>(*std::exchange(arrived.clip, std::nullopt), readiness);
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
