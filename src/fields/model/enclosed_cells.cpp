#include "fields/model/enclosed_cells.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace kinora::fields {
namespace {

using Word = std::uint64_t;
static_assert(FieldLimits::kMaxOccupancyResolution % 64 == 0);
using Row = std::array<Word, FieldLimits::kMaxOccupancyResolution / 64>;

// Bits of `free` that runs of it connect with one of `seeds`, a part of it (Kogge, Stone, 1973).
Word spread(Word seeds, Word free) {
  Word up = seeds, down = seeds, through_up = free, through_down = free;
  for (int shift = 1; shift < 64; shift *= 2) {
    up |= through_up & (up << shift);
    through_up &= through_up << shift;
    down |= through_down & (down >> shift);
    through_down &= through_down >> shift;
  }
  return up | down;
}

/// Which empty cells are reached from outside, row after row along x until no row lets in more.
class Flood {
public:
  explicit Flood(const Occupancy& occupancy)
      : side_(occupancy.resolution()), words_(static_cast<std::size_t>(side_) / 64), occupied_(occupancy.words()),
        reached_(occupied_.size(), 0), waits_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), true) {
    for (int z = 0; z < side_; ++z) {
      for (int y = 0; y < side_; ++y) waiting_.push_back({y, z});
    }
  }

  Occupancy unreached() {
    while (!waiting_.empty()) {
      const auto [y, z] = waiting_.back();
      waiting_.pop_back();
      waits_[row_of(y, z)] = false;
      if (!grow(y, z)) continue;
      for (const auto& [dy, dz] : kBeside) wait(y + dy, z + dz);
    }
    Occupancy enclosed(side_);
    for (std::size_t w = 0; w < reached_.size(); ++w) enclosed.words()[w] = ~(occupied_[w] | reached_[w]);
    return enclosed;
  }

private:
  static constexpr std::array<std::array<int, 2>, 4> kBeside = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};

  bool is_row(int y, int z) const { return y >= 0 && z >= 0 && y < side_ && z < side_; }
  std::size_t row_of(int y, int z) const {
    return static_cast<std::size_t>(z) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(y);
  }
  void wait(int y, int z) {
    if (!is_row(y, z) || waits_[row_of(y, z)]) return;
    waits_[row_of(y, z)] = true;
    waiting_.push_back({y, z});
  }

  // Lets in what is beside a row; whether that was anything new.
  bool grow(int y, int z) {
    const std::size_t first = row_of(y, z) * words_;
    Row seeds{};
    std::copy_n(reached_.begin() + static_cast<std::ptrdiff_t>(first), words_, seeds.begin());
    for (const auto& [dy, dz] : kBeside) {
      if (!is_row(y + dy, z + dz)) {
        seeds.fill(~Word{0});
        break;
      }
      const std::size_t beside = row_of(y + dy, z + dz) * words_;
      for (std::size_t w = 0; w < words_; ++w) seeds[w] |= reached_[beside + w];
    }
    seeds[0] |= 1;
    seeds[words_ - 1] |= Word{1} << 63;
    const auto fill = [&](std::size_t w) {
      const Word free = ~occupied_[first + w];
      seeds[w] = spread(seeds[w] & free, free);
    };
    for (std::size_t w = 0; w < words_; ++w) {
      if (w > 0) seeds[w] |= seeds[w - 1] >> 63;
      fill(w);
    }
    for (std::size_t w = words_ - 1; w-- > 0;) {
      seeds[w] |= seeds[w + 1] << 63;
      fill(w);
    }
    const auto row = reached_.begin() + static_cast<std::ptrdiff_t>(first);
    if (std::equal(row, row + static_cast<std::ptrdiff_t>(words_), seeds.begin())) return false;
    std::copy_n(seeds.begin(), words_, row);
    return true;
  }

  int side_;
  std::size_t words_; // of a row
  const std::vector<Word>& occupied_;
  std::vector<Word> reached_;
  std::vector<std::array<int, 2>> waiting_; // rows, as y and z
  std::vector<bool> waits_;
};

} // namespace

Occupancy enclosed_cells(const Occupancy& occupancy) { return Flood(occupancy).unreached(); }

} // namespace kinora::fields
