#include "core/frame_range.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <string_view>

#include "core/error.h"

namespace kinora {

int FrameRange::at_or_after(int index) const {
  if (index <= begin) return begin;
  const std::int64_t steps = (std::int64_t{index} - begin + step - 1) / step;
  return static_cast<int>(std::min<std::int64_t>(begin + steps * step, std::numeric_limits<int>::max()));
}

int FrameRange::count_of(int count) const {
  const int last = end ? std::min(*end, count) : count;
  return last <= begin ? 0 : (last - begin - 1) / step + 1; // no sum that a plugin's count could overflow
}

std::vector<int> FrameRange::frames_of(int count) const {
  std::vector<int> frames;
  frames.reserve(static_cast<std::size_t>(count_of(count)));
  for (int i = 0; i < count_of(count); ++i) frames.push_back(begin + i * step);
  return frames;
}

FrameRange FrameRange::parse(const std::string& text) {
  const auto fail = [&text] {
    throw Error(ErrorCode::kUsage, "frames \"" + text +
                                       "\": write A:B:S, from A (counted from 0) to before B in steps of S, or one "
                                       "number for one frame");
  };
  std::vector<std::optional<int>> parts;
  for (std::string_view rest = text;;) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    const std::string_view part = rest.substr(0, end);
    int value = 0;
    const auto [stop, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (!part.empty() && (error != std::errc() || stop != part.data() + part.size() || value < 0)) fail();
    parts.push_back(part.empty() ? std::nullopt : std::optional(value));
    if (end == rest.size()) break;
    rest.remove_prefix(end + 1);
  }
  if (parts.size() > 3 || (parts.size() == 1 && !parts[0])) fail();
  FrameRange range;
  range.begin = parts[0].value_or(0);
  if (parts.size() == 1) range.end = range.begin + 1;
  if (parts.size() > 1) range.end = parts[1];
  if (parts.size() > 2) range.step = parts[2].value_or(1);
  if (range.step < 1 || (range.end && *range.end <= range.begin)) fail();
  return range;
}

} // namespace kinora
