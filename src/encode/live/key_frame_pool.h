// The frames that live training looks at: some of all that was seen, and the newest.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "ingest/frame/frame.h"

namespace kinora::encode {

struct KeyFrame {
  int number = 0; ///< on the timeline
  std::shared_ptr<const ingest::Frame> frame;
};

/// Of the frames so far every n-th, and the last one. Whenever there are too many every other one goes and n doubles:
/// however long the capture is, they are spread evenly over all of it. Thread-safe.
class KeyFramePool {
public:
  /// At least 2 frames.
  explicit KeyFramePool(std::size_t capacity);

  /// Frames come in the order of their numbers.
  void add(const KeyFrame& frame);
  /// Ascending, at most as many as the pool has room for.
  std::vector<KeyFrame> frames() const;

private:
  std::size_t capacity_;
  mutable std::mutex mutex_;
  std::vector<KeyFrame> kept_;
  KeyFrame last_;
  std::size_t added_ = 0;
  std::size_t interval_ = 1;
};

} // namespace kinora::encode
