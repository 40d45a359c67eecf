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
#include "container/cue_index.h"
#include "player/arrived_clip.h"
#include "player/clip_so_far.h"
#include "player/held_bytes.h"
#include "player/playback_clock.h"

namespace kinora::player {

/// Reads a clip from its first byte on, in a thread of its own, and makes ready what is whole: a first look as soon as
/// all layers have come, coarse as they are then; later layers as their fields come, frames as their motion comes. What
/// is damaged or cut is left out, and said. What is sought comes first, where the file has an index. A file that its
/// writer has not finished is followed. Thread-safe.
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

  /// What is shown at that time, in seconds of the clip, is to come before what lies between.
  void seek(double seconds);

private:
  using ByteRange = container::ByteRange;

  void follow(const std::stop_token& stop);
  void read_to_end(const std::stop_token& stop);
  void read_piece(const ByteRange& missing);
  void read_head_again();
  void look_for_sought();
  ByteRange next_missing() const;
  bool all_there() const { return !held_.missing(0, source_->size()); }
  bool finished();
  void take_first_look(const std::string& message);
  void make_ready();
  void make_ready_what_came();
  void show(ArrivedClip arrived, Readiness readiness);
  void tell(bool complete, std::string message);

  // The thread's own.
  std::unique_ptr<container::ByteSource> source_;
  MasterClock seconds_;
  HeldBytes held_;
  std::optional<std::optional<container::CueIndex>> index_ = std::nullopt; ///< once it was looked for
  std::uint64_t from_ = 0;                      ///< what is missing behind this comes before what is missing at all
  std::optional<ByteRange> due_ = std::nullopt; ///< what was sought, until it has come
  std::optional<Readiness> readiness_ = std::nullopt; ///< of what is to be seen
  std::size_t first_look_bytes_ = 0;                  ///< with which it is tried again
  double looked_at_ = 0;                              ///< time of the last try to make something ready
  std::size_t ready_bytes_ = 0;                       ///< that were there then
  std::string missing_;                               ///< of what was made ready last

  mutable std::mutex mutex_;     ///< of what follows
  std::optional<double> sought_; ///< seconds; by nobody looked for yet
  ClipSoFar newest_;
  std::exception_ptr fault_; ///< why nothing can be shown
  std::jthread thread_;      // last: it ends first
};

} // namespace kinora::player
