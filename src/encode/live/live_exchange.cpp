#include "encode/live/live_exchange.h"

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

} // namespace kinora::encode
