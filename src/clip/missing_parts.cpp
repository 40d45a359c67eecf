#include "clip/missing_parts.h"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

namespace kinora::clip {

namespace {

std::string enumeration(std::span<const std::string> phrases) {
  std::string text;
  for (std::size_t i = 0; i < phrases.size(); ++i) {
    if (i > 0) text += i + 1 == phrases.size() ? " and " : ", ";
    text += phrases[i];
  }
  return text;
}

std::string run_of_frames(std::size_t first, std::size_t last, std::span<const double> times) {
  if (first == last) return fmt::format("frame {} ({:.2f} s)", first, times[first]);
  return fmt::format("frames {} to {} ({:.2f} to {:.2f} s)", first, last, times[first], times[last]);
}

} // namespace

std::string missing_frames(const std::vector<bool>& there, std::span<const double> times) {
  constexpr std::size_t kMaxRuns = 3;
  std::vector<std::string> runs;
  std::size_t further = 0;
  for (auto from = std::find(there.begin(), there.end(), false); from != there.end();) {
    const auto to = std::find(from, there.end(), true);
    const auto first = static_cast<std::size_t>(from - there.begin());
    const auto end = static_cast<std::size_t>(to - there.begin());
    if (runs.size() < kMaxRuns) {
      runs.push_back(run_of_frames(first, end - 1, times));
    } else {
      further += end - first;
    }
    from = std::find(to, there.end(), false);
  }
  if (further > 0) runs.push_back(fmt::format("{} further frames", further));
  return enumeration(runs);
}

std::string missing_sentence(const std::string& name, std::span<const std::string> missing) {
  return fmt::format("{} is damaged; missing: {}; kinora validate says where", name, fmt::join(missing, "; "));
}

} // namespace kinora::clip
