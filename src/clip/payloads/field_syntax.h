// The bits of a field's occupancy, table and networks, written once for both directions of an arithmetic coder.
// docs/container.md specifies them.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "clip/coding/range_coder.h"
#include "core/error.h"
#include "fields/model/field.h"

namespace kinora::clip {

/// 0, 1, 2–3, 4–7, … as 0, 1, 2, 3, …, at most `last`.
inline std::size_t size_class(std::uint32_t size, std::size_t last) {
  std::size_t result = 0;
  for (; size != 0 && result < last; size >>= 1) ++result;
  return result;
}

/// An integer that must fit 16 bits. Throws Error(kCorruptInput) naming `location` if it does not.
template <class Coder>
std::int16_t code_parameter(Coder& coder, IntegerModel& model, std::int16_t value, const std::string& location) {
  const std::int32_t coded = code_integer(coder, model, value);
  if (coded < INT16_MIN || coded > INT16_MAX) {
    throw Error(ErrorCode::kCorruptInput, location + ": a field's parameter is out of range");
  }
  return static_cast<std::int16_t>(coded);
}

/// The integers of one level, kFeatures for each touched entry. A model is chosen by the feature, by the mean size of
/// the entry's features before it, and by the size of the same feature in the entry before.
template <class Coder> void code_level(Coder& coder, std::span<std::int16_t> values, const std::string& location) {
  constexpr std::size_t kFeatures = fields::FieldConfig::kFeatures;
  constexpr std::size_t kBefore = 6;
  constexpr std::size_t kAbove = 4;
  std::vector<IntegerModel> models(kFeatures * kBefore * kAbove);
  for (std::size_t i = 0; i < values.size(); i += kFeatures) {
    std::uint32_t sum = 0;
    for (std::size_t f = 0; f < kFeatures; ++f) {
      const std::uint32_t mean = f == 0 ? 0 : 2 * sum / static_cast<std::uint32_t>(f);
      const int above = i == 0 ? 0 : values[i + f - kFeatures];
      const std::size_t context =
          size_class(mean, kBefore - 1) * kAbove + size_class(static_cast<std::uint32_t>(std::abs(above)), kAbove - 1);
      values[i + f] = code_parameter(coder, models[f * kBefore * kAbove + context], values[i + f], location);
      sum += static_cast<std::uint32_t>(std::abs(int{values[i + f]}));
    }
  }
}

/// The integers of one matrix.
template <class Coder> void code_matrix(Coder& coder, std::span<std::int16_t> values, const std::string& location) {
  IntegerModel model;
  for (std::int16_t& value : values) value = code_parameter(coder, model, value, location);
}

/// Bits 0 to 10: cells x − 2 … x + 8 of a row, 0 outside; x is a multiple of 8.
inline std::uint32_t cells_about(const fields::Occupancy& cells, int x, int y, int z) {
  const int side = cells.resolution();
  if (y < 0 || z < 0 || y >= side || z >= side) return 0;
  const std::size_t per_row = static_cast<std::size_t>(side) / 64;
  const std::uint64_t* row =
      cells.words().data() +
      (static_cast<std::size_t>(z) * static_cast<std::size_t>(side) + static_cast<std::size_t>(y)) * per_row;
  const std::size_t w = static_cast<std::size_t>(x) / 64;
  const int bit = x % 64;
  std::uint64_t bits = bit == 0 ? row[w] << 2 : row[w] >> (bit - 2);
  if (bit == 0 && w > 0) bits |= row[w - 1] >> 62;
  if (bit == 56 && w + 1 < per_row) bits |= (row[w + 1] & 1U) << 10;
  return static_cast<std::uint32_t>(bits & 0x7FFU);
}

/// Cells of `source` into `coded`, which is empty at first. Blocks of 8³ cells, x fastest, each with a bit that says
/// whether any cell is occupied, and then one for each cell, given the ten beside it that may have come before.
template <class Coder> void code_occupancy(Coder& coder, const fields::Occupancy& source, fields::Occupancy& coded) {
  constexpr int kBlock = 8;
  const int r = coded.resolution();
  const fields::Occupancy blocks = fields::coarsened(source, kBlock);
  fields::Occupancy coded_blocks(blocks.resolution());
  std::array<BitModel, 8> block_models;
  std::vector<BitModel> cell_models(1024);
  const auto is_set = [](const fields::Occupancy& cells, int x, int y, int z) {
    const int side = cells.resolution();
    return x >= 0 && y >= 0 && z >= 0 && x < side && y < side && z < side && cells.at(x, y, z);
  };
  const auto code_cells = [&](int block_x, int block_y, int block_z) {
    for (int z = block_z * kBlock; z < (block_z + 1) * kBlock; ++z) {
      for (int y = block_y * kBlock; y < (block_y + 1) * kBlock; ++y) {
        const int x = block_x * kBlock;
        const std::uint32_t wanted = cells_about(source, x, y, z);
        const std::uint32_t above = cells_about(coded, x, y - 1, z), before = cells_about(coded, x, y, z - 1);
        const std::uint32_t below_before = cells_about(coded, x, y + 1, z - 1);
        const std::uint32_t above_before = cells_about(coded, x, y - 1, z - 1);
        std::uint32_t row = cells_about(coded, x, y, z);
        for (int i = 0; i < kBlock; ++i) {
          // By x, y and z from the cell: (−1, 0, 0), (−2, 0, 0); (0, −1, 0), (1, −1, 0), (−1, −1, 0); (0, 0, −1),
          // (1, 0, −1); (0, 1, −1); (−1, 0, −1); (0, −1, −1).
          const std::uint32_t context = (row >> (i + 1) & 1U) | (row >> i & 1U) << 1U | (above >> (i + 2) & 3U) << 2U |
                                        (above >> (i + 1) & 1U) << 4U | (before >> (i + 2) & 3U) << 5U |
                                        (below_before >> (i + 2) & 1U) << 7U | (before >> (i + 1) & 1U) << 8U |
                                        (above_before >> (i + 2) & 1U) << 9U;
          if (!coder.code(cell_models[context], (wanted >> (i + 2) & 1U) != 0)) continue;
          row |= 4U << i;
          coded.set(x + i, y, z);
        }
      }
    }
  };
  for (int z = 0; z < r / kBlock; ++z) {
    for (int y = 0; y < r / kBlock; ++y) {
      for (int x = 0; x < r / kBlock; ++x) {
        const std::size_t context = (is_set(coded_blocks, x - 1, y, z) ? 1U : 0U) |
                                    (is_set(coded_blocks, x, y - 1, z) ? 2U : 0U) |
                                    (is_set(coded_blocks, x, y, z - 1) ? 4U : 0U);
        if (!coder.code(block_models[context], blocks.at(x, y, z))) continue;
        coded_blocks.set(x, y, z);
        code_cells(x, y, z);
      }
    }
  }
}

} // namespace kinora::clip
