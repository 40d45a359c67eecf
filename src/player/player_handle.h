// What KinoraPlayer of include/kinora/player.h is.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <utility>

#include "player/playback_clock.h"
#include "player/player.h"

struct KinoraPlayer {
  explicit KinoraPlayer(kinora::clip::Clip clip, std::uint64_t file_bytes)
      : player(std::move(clip)), bytes(file_bytes), clock(player.clip().times) {}

  kinora::player::Player player;
  std::uint64_t bytes;
  std::atomic<std::uint64_t> cancellations = 0;
  mutable std::mutex clock_mutex;
  kinora::player::PlaybackClock clock;
};
