// Where sound comes from: a capture, or a file of its own.
#pragma once

#include <cstdint>
#include <optional>

#include "container/sound.h"

namespace kinora::sound {

/// Packets one after the other. Not thread-safe.
class SoundSource {
public:
  virtual ~SoundSource() = default;
  /// With container::kSoundTrack as its id; its name is empty.
  virtual const container::Track& track() const = 0;
  /// The next packet, its time from the beginning of the source; false at the end. Throws Error(kCorruptInput).
  virtual bool next(container::Payload& packet) = 0;
};

/// Hands packets out in step with frames.
class SoundFeed {
public:
  /// The source outlives it.
  explicit SoundFeed(SoundSource& source) : source_(&source) {}

  /// The next packet if its time is not later than that; else false.
  bool next_until(std::int64_t time_ns, container::Payload& packet) {
    if (!waiting_) {
      waiting_.emplace();
      if (!source_->next(*waiting_)) waiting_->time_ns = kEnd;
    }
    if (waiting_->time_ns == kEnd || waiting_->time_ns > time_ns) return false;
    packet = std::move(*waiting_);
    waiting_.reset();
    return true;
  }

private:
  static constexpr std::int64_t kEnd = INT64_MAX;

  SoundSource* source_;
  std::optional<container::Payload> waiting_; ///< too late so far, or with kEnd: there is no further one
};

/// All packets from `begin_ns` to `end_ns`, whose times then count from `begin_ns`; and the one before, which may last
/// beyond `begin_ns` and then has a negative time.
container::Sound excerpt(SoundSource& source, std::int64_t begin_ns, std::int64_t end_ns);

} // namespace kinora::sound
