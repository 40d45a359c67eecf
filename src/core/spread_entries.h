// What is worth remembering of a long sequence: entries that lie apart from each other.
// Source: Glocker et al., "Real-Time RGB-D Camera Relocalization via Randomized Ferns for Keyframe Encoding", TVCG 2015
// (a frame is kept if it differs from all that were kept).
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace kinora {

/// Entries at least `apart` from each other, in order of time; where they would be more than `most`, the distance
/// grows.
template <class Entry> class SpreadEntries {
public:
  SpreadEntries(double apart, std::size_t most) : apart_(apart), most_(most) {}

  /// Keeps the entry if distance(entry, other) is large enough for all that are kept.
  template <class Distance> void add(Entry entry, const Distance& distance) {
    constexpr double kGrowth = 1.25;
    keep(std::move(entry), distance);
    while (entries_.size() > most_) {
      apart_ *= kGrowth;
      for (Entry& kept : std::exchange(entries_, {})) keep(std::move(kept), distance);
    }
  }

  const std::vector<Entry>& entries() const { return entries_; }

private:
  template <class Distance> void keep(Entry entry, const Distance& distance) {
    const auto is_near = [&](const Entry& other) { return distance(entry, other) < apart_; };
    if (std::none_of(entries_.begin(), entries_.end(), is_near)) entries_.push_back(std::move(entry));
  }

  double apart_;
  std::size_t most_;
  std::vector<Entry> entries_;
};

} // namespace kinora
