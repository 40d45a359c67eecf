// Frames in a row that did not show where something is. It is held where it was, and lost once they are many.
#pragma once

#include "motion/motion.h"

namespace kinora::tracking {

class HeldOrLost {
public:
  /// `held_frames`: in a row without it; in the one after these it is lost.
  explicit HeldOrLost(int held_frames) : held_frames_(held_frames) {}

  /// The next frame, and what it says by itself; returns that, but kLost where the gap has become too long.
  motion::Health add(motion::Health seen) {
    frames_ = seen == motion::Health::kTracked ? 0 : frames_ + 1;
    return frames_ > held_frames_ ? motion::Health::kLost : seen;
  }

  /// 0 if the last frame showed it.
  int frames() const { return frames_; }
  bool is_open() const { return frames_ > 0; }

private:
  int held_frames_;
  int frames_ = 0;
};

} // namespace kinora::tracking
