#include "encode/live/key_frame_pool.h"

#include <algorithm>

namespace kinora::encode {

KeyFramePool::KeyFramePool(std::size_t capacity) : capacity_(std::max<std::size_t>(capacity, 2)) {}

void KeyFramePool::add(const KeyFrame& frame) {
  const std::lock_guard lock(mutex_);
  last_ = frame;
  if (added_++ % interval_ != 0) return;
  if (kept_.size() + 1 == capacity_) { // the last one needs room, too
    for (std::size_t i = 0; 2 * i < kept_.size(); ++i) kept_[i] = kept_[2 * i];
    kept_.resize((kept_.size() + 1) / 2);
    interval_ *= 2;
    if ((added_ - 1) % interval_ != 0) return;
  }
  kept_.push_back(frame);
}

std::vector<KeyFrame> KeyFramePool::frames() const {
  const std::lock_guard lock(mutex_);
  std::vector<KeyFrame> frames = kept_;
  if (last_.frame && frames.back().number != last_.number) frames.push_back(last_);
  return frames;
}

} // namespace kinora::encode
