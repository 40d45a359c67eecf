#include "encode/live/live_exchange.h"

#include <algorithm>
#include <iterator>

namespace kinora::encode {

void LiveExchange::give(LiveSnapshot snapshot) {
  auto given = std::make_shared<const LiveSnapshot>(std::move(snapshot));
  {
    const std::lock_guard lock(mutex_);
    snapshot_ = std::move(given);
    wanted_ = false;
  }
  given_.notify_one();
}

void LiveExchange::rethrow() const {
  const std::lock_guard lock(mutex_);
  if (error_) std::rethrow_exception(error_);
}

std::shared_ptr<const LiveSnapshot> LiveExchange::newest(const LiveSnapshot* known) {
  std::unique_lock lock(mutex_);
  wanted_ = true;
  given_.wait(lock, [&] { return snapshot_ != nullptr && snapshot_.get() != known; });
  return snapshot_;
}

void LiveExchange::fail(std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  error_ = std::move(error);
}

void LiveExchange::show(KeyFrame frame) {
  constexpr std::size_t kMax = 16;
  const std::lock_guard lock(mutex_);
  if (shown_.size() == kMax) {
    for (std::size_t i = 1; 2 * i < kMax; ++i) shown_[i] = std::move(shown_[2 * i]);
    shown_.resize(kMax / 2);
  }
  shown_.push_back(std::move(frame));
}

std::vector<KeyFrame> LiveExchange::take_frames(int end) {
  const std::lock_guard lock(mutex_);
  const auto later = std::ranges::find_if(shown_, [end](const KeyFrame& frame) { return frame.number >= end; });
  std::vector<KeyFrame> taken(std::move_iterator(shown_.begin()), std::move_iterator(later));
  shown_.erase(shown_.begin(), later);
  return taken;
}

} // namespace kinora::encode
