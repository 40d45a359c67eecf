// What is worth remembering of a long sequence: entries that lie apart from each other.
// Source: Glocker et al., "Real-Time RGB-D Camera Relocalization via Randomized Ferns for Keyframe Encoding", TVCG 2015
// (a frame is kept if it differs from all that were kept).
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace kinora {

/// Entries at least `min_distance` from each other, in order of time; where they would be more than `max_size`, the
/// distance grows.
template <class Entry> class DiverseSet {
public:
  DiverseSet(double min_distance, std::size_t max_size) : min_distance_(min_distance), max_size_(max_size) {}

  /// Keeps the entry if distance(entry, other) is large enough for all that are kept.
  template <class Distance> void add(Entry entry, const Distance& distance) {
    constexpr double kGrowth = 1.25;
    insert_if_far(std::move(entry), distance);
    while (entries_.size() > max_size_) {
      min_distance_ *= kGrowth;
      for (Entry& entry_kept : std::exchange(entries_, {})) insert_if_far(std::move(entry_kept), distance);
    }
  }

  const std::vector<Entry>& entries() const { return entries_; }

private:
  template <class Distance> void insert_if_far(Entry entry, const Distance& distance) {
    const auto is_near = [&](const Entry& other) { return distance(entry, other) < min_distance_; };
    if (std::none_of(entries_.begin(), entries_.end(), is_near)) entries_.push_back(std::move(entry));
  }

  double min_distance_;
  std::size_t max_size_;
  std::vector<Entry> entries_;
};

} // namespace kinora
