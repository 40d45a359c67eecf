// What there is of a clip that may still be on its way.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "player/player.h"

namespace kinora::player {

struct ClipSoFar {
  std::shared_ptr<const Player> player; ///< null while nothing can be shown
  bool complete = false;                ///< nothing more will come
  std::string message;                  ///< what is waited for, missing or wrong; empty: there is nothing to say
  std::uint64_t bytes = 0;              ///< of the file, as far as is known
  std::vector<double> times = {};       ///< of all frames that the file says it has, seconds; the player has the first
  std::vector<bool> there = {};         ///< whether each of them has come
};

} // namespace kinora::player
