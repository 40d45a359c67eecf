#include "motion/presence.h"

#include <algorithm>

#include "core/error.h"

namespace kinora::motion {

Presence Presence::away_during(std::vector<FrameSpan> spans) {
  for (std::size_t i = 0; i < spans.size(); ++i) {
    if (spans[i].begin >= spans[i].end || (i > 0 && spans[i].begin <= spans[i - 1].end))
      throw Error(ErrorCode::kFailure, "the spans in which a layer is away are empty, touch or overlap");
  }
  Presence presence;
  presence.away_ = std::move(spans);
  return presence;
}

Presence Presence::of_frames(const std::vector<bool>& there) {
  Presence presence;
  for (auto from = std::find(there.begin(), there.end(), false); from != there.end();) {
    const auto to = std::find(from, there.end(), true);
    presence.away_.push_back(
        {static_cast<std::size_t>(from - there.begin()), static_cast<std::size_t>(to - there.begin())});
    from = std::find(to, there.end(), false);
  }
  return presence;
}

bool Presence::at(double frame) const {
  // The first span that ends behind the frame.
  const auto span = std::find_if(away_.begin(), away_.end(),
                                 [frame](const FrameSpan& away) { return frame < static_cast<double>(away.end); });
  return span == away_.end() || frame < static_cast<double>(span->begin);
}

std::vector<bool> Presence::in_frames(std::size_t count) const {
  std::vector<bool> there(count, true);
  for (const FrameSpan& away : away_) {
    for (std::size_t frame = away.begin; frame < std::min(away.end, count); ++frame) there[frame] = false;
  }
  return there;
}

} // namespace kinora::motion
