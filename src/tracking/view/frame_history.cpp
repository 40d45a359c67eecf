#include "tracking/view/frame_history.h"

#include <algorithm>
#include <cmath>

namespace kinora::tracking {
namespace {

constexpr std::size_t kMaxBytes = 200'000'000;
constexpr std::size_t kBytesPerPixel = 8;

template <class T> Image<T> cut(const Image<T>& image, int u0, int v0, const Intrinsics& size) {
  Image<T> result(size.width, size.height, image.channels());
  const auto row = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(image.channels());
  for (int v = 0; v < size.height; ++v) std::copy_n(image.pixel(u0, v0 + v), row, result.pixel(0, v));
  return result;
}

std::size_t bytes_of(const ingest::Frame& frame) { return kBytesPerPixel * frame.color.pixel_count(); }

} // namespace

void FrameHistory::add(const ingest::Frame& frame, const LayerView& view) {
  ++count_;
  ingest::Frame& kept = frames_.emplace_back();
  if (view.empty()) return;
  kept.index = frame.index;
  kept.time = frame.time;
  kept.camera = {view.intrinsics, frame.camera.camera_to_world};
  const int u0 = static_cast<int>(std::lround(frame.camera.intrinsics.cx - view.intrinsics.cx));
  const int v0 = static_cast<int>(std::lround(frame.camera.intrinsics.cy - view.intrinsics.cy));
  kept.color = cut(frame.color, u0, v0, view.intrinsics);
  kept.clean_depth = cut(frame.clean_depth, u0, v0, view.intrinsics);
  if (frame.has_labels()) kept.labels = cut(frame.labels, u0, v0, view.intrinsics);
  bytes_ += bytes_of(kept);
  for (; bytes_ > kMaxBytes; frames_.pop_front()) bytes_ -= bytes_of(frames_.front());
}

ingest::Frame FrameHistory::at(std::size_t number) const {
  ingest::Frame frame = frames_[number - begin()];
  frame.depth = frame.clean_depth;
  return frame;
}

} // namespace kinora::tracking
