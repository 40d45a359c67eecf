// How alike two words are, to guess what somebody meant.
#pragma once

#include <algorithm>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kinora {

/// Letters to insert, remove or change to make one word of the other. Source: Levenshtein, "Binary codes capable of
/// correcting deletions, insertions, and reversals", 1966.
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0U);
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t k = 0; k < b.size(); ++k) {
      const std::size_t changed = diagonal + (a[i] == b[k] ? 0 : 1);
      diagonal = row[k + 1];
      row[k + 1] = std::min({changed, row[k] + 1, diagonal + 1});
    }
  }
  return row.back();
}

/// The word nearest to `wanted`, of equally near ones the first; empty if there are none.
inline std::string nearest_word(std::string_view wanted, std::span<const std::string> words) {
  const auto nearer = [wanted](const std::string& a, const std::string& b) {
    return edit_distance(wanted, a) < edit_distance(wanted, b);
  };
  const auto nearest = std::min_element(words.begin(), words.end(), nearer);
  return nearest == words.end() ? std::string() : *nearest;
}

} // namespace kinora
