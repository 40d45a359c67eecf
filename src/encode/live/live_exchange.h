// Where the two threads of live encoding meet: what the front end gives, and what the trainer asks for.
#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <vector>

#include "encode/live/key_frame_pool.h"
#include "encode/live/live_snapshot.h"

namespace kinora::encode {

/// The front end never waits here but for the trainer's end. Thread-safe.
class LiveExchange {
public:
  // The front end's side.
  bool wants_snapshot() const { return wanted_; }
  void give(LiveSnapshot snapshot);
  /// A frame that may be trained on. Where the trainer does not take them, every other one is forgotten.
  void show(KeyFrame frame);
  /// The trainer is to end at once.
  void stop() { stopped_ = true; }
  /// Throws again what ended the trainer, if anything did.
  void rethrow() const;

  // The trainer's side.
  /// The newest snapshot, and asks for another. Waits while there is none but `known`.
  std::shared_ptr<const LiveSnapshot> newest(const LiveSnapshot* known = nullptr);
  /// Those shown since the last call with numbers below `end`, in order; later ones stay.
  std::vector<KeyFrame> take_frames(int end);
  bool is_stopped() const { return stopped_; }
  void fail(std::exception_ptr error);

private:
  std::atomic<bool> wanted_ = true;
  std::atomic<bool> stopped_ = false;
  mutable std::mutex mutex_;
  std::condition_variable given_;
  std::shared_ptr<const LiveSnapshot> snapshot_;
  std::vector<KeyFrame> shown_;
  std::exception_ptr error_;
};

} // namespace kinora::encode
