#include "common/live_frames.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/capture_info.h"
#include "core/error.h"

namespace kinora::formats {
namespace {

constexpr double kMaxTimeDifference = 0.02;
constexpr std::size_t kMaxWaiting = 15;
constexpr auto kPatience = std::chrono::seconds(2);

} // namespace

LiveFrames::LiveFrames(std::string address, double seconds) : address_(std::move(address)), seconds_(seconds) {
  if (!(seconds > 0 && seconds <= 1e6)) throw Error(ErrorCode::kUsage, "seconds must lie between 0 and a million");
}

void LiveFrames::add(double time, ColorImage color) {
  const std::lock_guard lock(mutex_);
  color_ = {time, std::move(color)};
  pair_up();
}

void LiveFrames::add(double time, DepthImage16 depth) {
  const std::lock_guard lock(mutex_);
  depth_ = {time, std::move(depth)};
  pair_up();
}

void LiveFrames::pair_up() {
  if (!color_ || !depth_ || std::abs(color_->time - depth_->time) > kMaxTimeDifference) return;
  if (!first_time_) first_time_ = color_->time;
  waiting_.push_back({color_->time - *first_time_, std::move(color_->picture), std::move(depth_->picture)});
  if (waiting_.size() > kMaxWaiting) waiting_.pop_front();
  color_.reset();
  depth_.reset();
  arrived_.notify_one();
}

void LiveFrames::fill_info(KinoraCaptureInfo& info, double frames_per_second) const {
  info.frame_count = std::max<std::int64_t>(std::llround(seconds_ * frames_per_second), 1);
  info.start_time = 0;
  info.frames_per_second = frames_per_second;
}

KinoraStatus LiveFrames::next(KinoraFrame& frame) {
  std::unique_lock lock(mutex_);
  if (!arrived_.wait_for(lock, kPatience, [this] { return !waiting_.empty(); }))
    throw Error(ErrorCode::kFailure, address_ + ": the camera gives no frames any more; is it still plugged in?");
  if (waiting_.front().time > seconds_) return KINORA_END;
  given_ = std::move(waiting_.front());
  waiting_.pop_front();
  frame.index = next_++;
  frame.time = given_.time;
  frame.color = view_of(given_.color, KINORA_PIXEL_U8);
  frame.depth = view_of(given_.depth, KINORA_PIXEL_U16);
  return KINORA_OK;
}

} // namespace kinora::formats
