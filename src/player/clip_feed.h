// A clip that comes bit by bit: over a network, or while it is still being written.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "container/byte_source.h"
#include "player/clip_so_far.h"
#include "player/playback_clock.h"

namespace kinora::player {

/// Reads a clip from its first byte on, in a thread of its own, and makes ready what is whole: a first look as soon as
/// all layers have come, coarse as they are then; later layers as their fields come, frames as their motion comes. What
/// is damaged or cut is left out, and said. A file that its writer has not finished is followed. Thread-safe.
class ClipFeed {
public:
  /// Bytes that it takes: a file is held in memory until all of it has come.
  static constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 30;

  /// `seconds` go on by themselves: a part is made ready only if it has been waited for, so that a file that is read
  /// at once is made ready once.
  explicit ClipFeed(std::unique_ptr<container::ByteSource> source, MasterClock seconds = steady_clock());

  ClipSoFar newest() const;
  /// Waits until there is something to show: a first look (Player::readiness()), or more. Throws what has prevented it,
  /// or Error(kInterrupted) once `stopped`.
  ClipSoFar first(const std::function<bool()>& stopped) const;

private:
  void follow(const std::stop_token& stop);
  void read_to_end(const std::stop_token& stop);
  void read_head_again();
  bool finished() const;
  void take_first_look(const std::string& message);
  void make_ready();
  void make_ready_what_came();
  void show(clip::Clip clip, Readiness readiness);
  void tell(bool complete, std::string message);

  // The thread's own.
  std::unique_ptr<container::ByteSource> source_;
  MasterClock seconds_;
  std::vector<std::byte> bytes_;
  std::optional<Readiness> readiness_ = std::nullopt; ///< of what is to be seen
  std::size_t first_look_bytes_ = 0;                  ///< with which it is tried again
  double looked_at_ = 0;                              ///< time of the last try to make something ready
  std::size_t ready_bytes_ = 0;                       ///< that were there then
  std::string missing_;                               ///< of what was made ready last

  mutable std::mutex mutex_; ///< of what follows
  ClipSoFar newest_;
  std::exception_ptr fault_; ///< why nothing can be shown
  std::jthread thread_;      // last: it ends first
};

} // namespace kinora::player
