#include "clip/shown_frames.h"

#include <algorithm>

#include "motion/first_frame.h"

namespace kinora::clip {

motion::Presence shown_frames(const Layer& layer, std::size_t frames, std::size_t birth) {
  std::vector<bool> shown = layer.presence.in_frames(frames);
  const std::size_t first = std::max(birth, motion::first_frame_of(layer.motion, frames));
  std::fill_n(shown.begin(), std::min(first, frames), false);
  return motion::Presence::of_frames(shown);
}

} // namespace kinora::clip
