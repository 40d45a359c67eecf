// What a reader passed over in a damaged file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kinora::container {

/// Bytes of a file that could not be used, and why.
struct Damage {
  std::uint64_t offset = 0;
  std::uint64_t end = 0;
  std::string why; ///< names the file and the byte
};

/// Neighbours are one entry; there are no more than kMaxEntries, and then a number.
class DamageList {
public:
  static constexpr std::size_t kMaxEntries = 1000;

  const std::vector<Damage>& entries() const { return entries_; }
  std::size_t further() const { return further_; } ///< entries that are not listed
  bool empty() const { return entries_.empty(); }
  std::uint64_t bytes() const { return bytes_; } ///< that were passed over

  void add(std::uint64_t offset, std::uint64_t end, const std::string& why) {
    if (!entries_.empty() && entries_.back().offset <= offset && offset <= entries_.back().end) {
      if (end <= entries_.back().end) return;
      bytes_ += end - entries_.back().end;
      entries_.back().end = end;
      return;
    }
    bytes_ += end - offset;
    if (entries_.size() < kMaxEntries) {
      entries_.push_back({offset, end, why});
    } else {
      ++further_;
    }
  }

private:
  std::vector<Damage> entries_;
  std::size_t further_ = 0;
  std::uint64_t bytes_ = 0;
};

} // namespace kinora::container
