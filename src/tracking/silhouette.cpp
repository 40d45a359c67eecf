#include "tracking/silhouette.h"

#include <cstdlib>
#include <limits>
#include <span>
#include <vector>

#include "core/parallel.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kRowsPerChunk = 32;
constexpr std::int16_t kNone = std::numeric_limits<std::int16_t>::max();

int squared(int value) { return value * value; }

// From each pixel to the nearest of its column; kNone if that has none.
Image<std::int16_t> offsets_along_columns(const LabelImage& allowed) {
  Image<std::int16_t> offsets(allowed.width(), allowed.height());
  const auto take = [&](int v, int before) {
    for (int u = 0; u < allowed.width(); ++u) {
      if (allowed.at(u, v) != 0) continue; // zero already
      const std::int16_t other = allowed.contains(u, v + before) ? offsets.at(u, v + before) : kNone;
      const auto through = static_cast<std::int16_t>(other == kNone ? kNone : other + before);
      std::int16_t& own = offsets.at(u, v);
      if (before < 0 || std::abs(through) < std::abs(own)) own = through;
    }
  };
  for (int v = 0; v < allowed.height(); ++v) take(v, -1);
  for (int v = allowed.height() - 1; v >= 0; --v) take(v, 1);
  return offsets;
}

/// Columns whose nearest pixels are nearest to some piece of a row, from left to right.
struct Piece {
  int column;
  int begin; ///< of the piece; it ends where the next begins
};

// `along_column`: of the row's pixels.
void find_pieces(std::span<const std::int16_t> along_column, std::vector<Piece>& pieces) {
  const auto cost = [&](int u, int column) {
    return squared(u - column) + squared(along_column[static_cast<std::size_t>(column)]);
  };
  pieces.clear();
  for (int column = 0; column < static_cast<int>(along_column.size()); ++column) {
    if (along_column[static_cast<std::size_t>(column)] == kNone) continue;
    while (!pieces.empty() && cost(pieces.back().begin, pieces.back().column) > cost(pieces.back().begin, column)) {
      pieces.pop_back();
    }
    if (pieces.empty()) {
      pieces.push_back({column, 0});
      continue;
    }
    const int other = pieces.back().column;
    const int begin = 1 + (cost(0, column) - cost(0, other)) / (2 * (column - other));
    if (begin < static_cast<int>(along_column.size())) pieces.push_back({column, begin});
  }
}

} // namespace

Image<std::int16_t> offsets_to_silhouette(const LabelImage& allowed) {
  const Image<std::int16_t> along_columns = offsets_along_columns(allowed);
  const auto width = static_cast<std::size_t>(allowed.width());
  const auto far = static_cast<std::int16_t>(2 * (allowed.width() + allowed.height()));
  Image<std::int16_t> offsets(allowed.width(), allowed.height(), 2, far);
  parallel_for(static_cast<std::size_t>(allowed.height()), kRowsPerChunk, [&](const Chunk& rows) {
    std::vector<Piece> pieces;
    for (std::size_t v = rows.begin; v < rows.end; ++v) {
      const std::span<const std::int16_t> along_column(along_columns.pixel(0, static_cast<int>(v)), width);
      find_pieces(along_column, pieces);
      for (std::size_t k = 0; k < pieces.size(); ++k) {
        const int column = pieces[k].column;
        const int end = k + 1 < pieces.size() ? pieces[k + 1].begin : allowed.width();
        for (int u = pieces[k].begin; u < end; ++u) {
          std::int16_t* offset = offsets.pixel(u, static_cast<int>(v));
          offset[0] = static_cast<std::int16_t>(column - u);
          offset[1] = along_column[static_cast<std::size_t>(column)];
        }
      }
    }
  });
  return offsets;
}

} // namespace kinora::tracking
