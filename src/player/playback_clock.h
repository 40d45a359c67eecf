// Which frame of a clip is to be shown now.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace kinora::player {

/// Seconds that go on by themselves: the system's steady clock, or the sound that has been heard. Need not start at 0.
using MasterClock = std::function<double()>;

MasterClock steady_clock();

/// Plays along a master clock. Every time that it gives is a frame's: the last whose time has come. Starts paused at
/// the first frame. Not thread-safe.
class PlaybackClock {
public:
  static constexpr double kMinSpeed = 1.0 / 16, kMaxSpeed = 16;

  /// `times`: of all frames, in seconds, increasing; at least one.
  explicit PlaybackClock(std::vector<double> times, MasterClock master = steady_clock());

  std::size_t frame() const;
  double position() const; ///< seconds of the clip, going on between frames; at most when the last frame has been shown
  double seconds() const { return times_[frame()]; } ///< of that frame
  bool playing() const { return playing_ && !ended(); }
  double speed() const { return speed_; }
  bool loop() const { return loop_; }

  /// From the start, if it stands at the end.
  void play();
  void pause();
  /// To a time of the clip, clamped; plays on if it plays.
  void seek(double seconds);
  /// Pauses, and goes that many frames on, or back; stays inside the clip.
  void step(int frames);
  /// Throws Error(kUsage) outside of kMinSpeed to kMaxSpeed.
  void set_speed(double speed);
  void set_loop(bool loop);
  void set_master(MasterClock master);
  /// Other frames, at least one, of the same clip, of which more has come. With `more_is_awaited` it waits at the end,
  /// playing, and repeats nothing; and, wherever it stands, before the first frame that is not `there` (one for each
  /// time; none: all are).
  void set_times(std::vector<double> times, bool more_is_awaited, std::vector<bool> there = {});
  /// Plays, and what is to be shown next has not come.
  bool starved() const;
  bool is_there(std::size_t frame) const { return !more_is_awaited_ || there_.empty() || there_[frame]; }

private:
  double end() const;   // when the last frame has been shown as long as the others
  double limit() const; // up to where it can go on from where it started
  bool ended() const;
  std::size_t frame_at(double position) const;
  void restart_at(double position);

  std::vector<double> times_;
  std::vector<bool> there_;
  MasterClock master_;
  double start_ = 0;        // position at...
  double start_master_ = 0; // ...this time of the master
  double speed_ = 1;
  bool playing_ = false;
  bool loop_ = false;
  bool more_is_awaited_ = false;
};

} // namespace kinora::player
