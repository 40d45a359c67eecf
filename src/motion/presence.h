// At which frames a layer is there: layers may begin and end within a clip.
#pragma once

#include <cstddef>
#include <vector>

namespace kinora::motion {

/// Frames from `begin` to before `end`.
struct FrameSpan {
  std::size_t begin = 0;
  std::size_t end = 0;
  friend bool operator==(const FrameSpan&, const FrameSpan&) = default;
};

/// Immutable; may be shared by threads.
class Presence {
public:
  /// Always there.
  Presence() = default;
  /// Away during these spans. Throws Error(kFailure) unless each has a frame and begins behind the end of the one
  /// before it, with a frame between them.
  static Presence away_during(std::vector<FrameSpan> spans);
  /// Of frame after frame: whether it is there. Behind the last it is.
  static Presence of_frames(const std::vector<bool>& there);

  /// At a whole or fractional frame, not negative. A fraction counts as the frame before it.
  bool at(double frame) const;
  bool is_always() const { return away_.empty(); }
  const std::vector<FrameSpan>& away() const { return away_; } ///< increasing, apart, none of them empty
  std::vector<bool> in_frames(std::size_t count) const;        ///< of each of the first `count` frames

  friend bool operator==(const Presence&, const Presence&) = default;

private:
  std::vector<FrameSpan> away_;
};

} // namespace kinora::motion
