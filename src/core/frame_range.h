// A:B:S of the command line: which frames of a capture, a clip or a list of cameras are meant.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace kinora {

/// Counts from 0; step at least 1.
struct FrameRange {
  int begin = 0;
  std::optional<int> end; ///< excluded; nothing: to the last frame
  int step = 1;

  bool contains(int index) const { return index >= begin && (!end || index < *end) && (index - begin) % step == 0; }
  /// The first number of the progression that is not below `index`, whether before `end` or not.
  int at_or_after(int index) const;
  /// How many of `count` frames it contains.
  int count_of(int count) const;
  /// Which of `count` frames it contains, ascending.
  std::vector<int> frames_of(int count) const;

  /// Throws Error(kUsage) on anything but A:B:S with parts that may be left out ("3", "10:20", "::5", "10:").
  static FrameRange parse(const std::string& text);
};

} // namespace kinora
