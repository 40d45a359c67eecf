#include "player/playback_clock.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::player {

namespace {

// Sums of times are no exact numbers: a frame that is due in a nanosecond is due.
constexpr double kNanosecond = 1e-9;

} // namespace

MasterClock steady_clock() {
  return [] { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); };
}

PlaybackClock::PlaybackClock(std::vector<double> times, MasterClock master)
    : times_(std::move(times)), master_(std::move(master)), start_(times_.front()), start_master_(master_()) {}

double PlaybackClock::end() const {
  constexpr double kSingleFrame = 1.0 / 30;
  const std::size_t count = times_.size();
  return count > 1 ? times_.back() + (times_.back() - times_.front()) / static_cast<double>(count - 1)
                   : times_.front() + kSingleFrame;
}

double PlaybackClock::limit() const {
  for (std::size_t f = frame_at(start_); f < times_.size(); ++f) {
    if (!is_there(f)) return std::max(start_, times_[f] - 2 * kNanosecond);
  }
  return end();
}

bool PlaybackClock::starved() const { return playing_ && more_is_awaited_ && position() >= limit(); }

double PlaybackClock::position() const {
  if (!playing_) return start_;
  const double gone = start_ + speed_ * std::max(0.0, master_() - start_master_);
  if (more_is_awaited_) return std::min(gone, limit());
  if (gone < end()) return gone;
  if (!loop_) return end();
  return times_.front() + std::fmod(gone - times_.front(), end() - times_.front());
}

bool PlaybackClock::ended() const { return !loop_ && !more_is_awaited_ && position() >= end(); }

std::size_t PlaybackClock::frame() const { return frame_at(position()); }

std::size_t PlaybackClock::frame_at(double position) const {
  const auto next = std::upper_bound(times_.begin(), times_.end(), position + kNanosecond);
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, next - times_.begin() - 1));
}

void PlaybackClock::restart_at(double position) {
  start_ = position;
  start_master_ = master_();
}

void PlaybackClock::play() {
  const bool at_end = !more_is_awaited_ && frame() + 1 == times_.size();
  restart_at(at_end && !playing() ? times_.front() : position());
  playing_ = true;
}

void PlaybackClock::pause() {
  restart_at(seconds());
  playing_ = false;
}

void PlaybackClock::seek(double seconds) { restart_at(std::clamp(seconds, times_.front(), times_.back())); }

void PlaybackClock::step(int frames) {
  const auto last = static_cast<std::ptrdiff_t>(times_.size()) - 1;
  const auto target = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(frame()) + frames, 0, last);
  playing_ = false;
  restart_at(times_[static_cast<std::size_t>(target)]);
}

void PlaybackClock::set_speed(double speed) {
  if (!(speed >= kMinSpeed && speed <= kMaxSpeed)) {
    throw Error(ErrorCode::kUsage, fmt::format("a speed of {} is not between 1/16 and 16", speed));
  }
  restart_at(position());
  speed_ = speed;
}

void PlaybackClock::set_loop(bool loop) {
  restart_at(position());
  loop_ = loop;
}

void PlaybackClock::set_master(MasterClock master) {
  const double now = position();
  master_ = std::move(master);
  restart_at(now);
}

void PlaybackClock::set_times(std::vector<double> times, bool more_is_awaited, std::vector<bool> there) {
  const double now = position();
  times_ = std::move(times);
  there_ = std::move(there);
  more_is_awaited_ = more_is_awaited;
  restart_at(std::clamp(now, times_.front(), end()));
}

} // namespace kinora::player
