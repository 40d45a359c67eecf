// What KinoraPlayer of include/kinora/player.h is.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "player/clip_so_far.h"
#include "player/playback_clock.h"
#include "player/player.h"

/// Thread-safe, but for `clock`, which `clock_mutex` guards.
struct KinoraPlayer {
  using ClipSoFar = kinora::player::ClipSoFar;
  using Player = kinora::player::Player;

  /// `newest`: what has come since; none if all is there.
  explicit KinoraPlayer(ClipSoFar first, std::function<ClipSoFar()> newest = {})
      : clock(first.player->clip().times), newest_(std::move(newest)), now_(std::move(first)) {
    if (!now_.complete) clock.set_times(now_.player->clip().times, true);
  }

  std::shared_ptr<const Player> player() const { return now().player; }
  ClipSoFar now() const {
    const std::lock_guard lock(mutex_);
    return now_;
  }
  /// Takes what has come; whether it shows more.
  bool update() {
    if (!newest_) return false;
    ClipSoFar newest = newest_();
    const std::scoped_lock lock(mutex_, clock_mutex);
    const bool more = newest.player != now_.player;
    if (more || newest.complete != now_.complete) clock.set_times(newest.player->clip().times, !newest.complete);
    now_ = std::move(newest);
    return more;
  }
  /// That text, for as long as this lives.
  const char* kept(const std::string& text) const {
    const std::lock_guard lock(mutex_);
    return kept_.insert(text).first->c_str();
  }

  std::atomic<std::uint64_t> cancellations = 0;
  mutable std::mutex clock_mutex;
  kinora::player::PlaybackClock clock;

private:
  std::function<ClipSoFar()> newest_;
  mutable std::mutex mutex_; // of what follows
  ClipSoFar now_;
  mutable std::set<std::string> kept_; // names of layers
};
