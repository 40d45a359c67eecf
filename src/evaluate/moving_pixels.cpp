#include "evaluate/moving_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "core/parallel.h"

namespace kinora::evaluate {
namespace {

constexpr std::size_t kMaxFrames = 120;
constexpr std::size_t kMinFrames = 3;
constexpr int kMinChange = 12; ///< of 255, mean over the channels

} // namespace

std::optional<MovingPixels> MovingPixels::of(ingest::Capture& capture) {
  if (capture.info().has_poses) return std::nullopt;
  // Every stride-th frame; when there are too many, every other one is dropped.
  std::vector<ColorImage> frames;
  std::size_t stride = 1;
  std::size_t position = 0;
  while (auto frame = capture.next()) {
    if (position++ % stride != 0) continue;
    frames.push_back(std::move(frame->color));
    if (frames.size() < kMaxFrames) continue;
    for (std::size_t i = 0; 2 * i < frames.size(); ++i) {
      if (i > 0) frames[i] = std::move(frames[2 * i]);
    }
    frames.resize((frames.size() + 1) / 2);
    stride *= 2;
  }
  if (frames.size() < kMinFrames) return std::nullopt;
  MovingPixels moving;
  moving.median_ = ColorImage(frames[0].width(), frames[0].height(), 3);
  const std::size_t values = moving.median_.values().size();
  parallel_for(values, 16384, [&](const Chunk& chunk) {
    std::vector<std::uint8_t> over_time(frames.size());
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      for (std::size_t f = 0; f < frames.size(); ++f) over_time[f] = frames[f].data()[i];
      const auto middle = over_time.begin() + static_cast<std::ptrdiff_t>(over_time.size() / 2);
      std::nth_element(over_time.begin(), middle, over_time.end());
      moving.median_.data()[i] = *middle;
    }
  });
  return moving;
}

LabelImage MovingPixels::in(const ColorImage& color) const {
  LabelImage moving(color.width(), color.height());
  for (int v = 0; v < color.height(); ++v) {
    for (int u = 0; u < color.width(); ++u) {
      int change = 0;
      for (int c = 0; c < 3; ++c) change += std::abs(color.at(u, v, c) - median_.at(u, v, c));
      if (change <= 3 * kMinChange) continue;
      for (int y = std::max(v - 1, 0); y <= std::min(v + 1, color.height() - 1); ++y) {
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, color.width() - 1); ++x) moving.at(x, y) = 1;
      }
    }
  }
  return moving;
}

} // namespace kinora::evaluate
