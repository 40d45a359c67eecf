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

/// Cells of `source` into `coded`, which is empty at first. Blocks of 8³ cells, x fastest, each with a bit that says
/// whether any cell is occupied, and then one for each cell, given the ten beside it that may have come before.
template <class Coder> void code_occupancy(Coder& coder, const fields::Occupancy& source, fields::Occupancy& coded) {
  constexpr int kBlock = 8;
  constexpr std::array<std::array<int, 3>, 10> kBeside{{{-1, 0, 0},
                                                        {-2, 0, 0},
                                                        {0, -1, 0},
                                                        {1, -1, 0},
                                                        {-1, -1, 0},
                                                        {0, 0, -1},
                                                        {1, 0, -1},
                                                        {0, 1, -1},
                                                        {-1, 0, -1},
                                                        {0, -1, -1}}};
  const int r = coded.resolution();
  const fields::Occupancy blocks = fields::coarsened(source, kBlock);
  fields::Occupancy coded_blocks(blocks.resolution());
  std::array<BitModel, 8> block_models;
  std::vector<BitModel> cell_models(std::size_t{1} << kBeside.size());
  const auto is_set = [](const fields::Occupancy& cells, int x, int y, int z) {
    const int side = cells.resolution();
    return x >= 0 && y >= 0 && z >= 0 && x < side && y < side && z < side && cells.at(x, y, z);
  };
  const auto code_cells = [&](int block_x, int block_y, int block_z) {
    for (int z = block_z * kBlock; z < (block_z + 1) * kBlock; ++z) {
      for (int y = block_y * kBlock; y < (block_y + 1) * kBlock; ++y) {
        for (int x = block_x * kBlock; x < (block_x + 1) * kBlock; ++x) {
          std::size_t context = 0;
          for (std::size_t b = 0; b < kBeside.size(); ++b) {
            if (is_set(coded, x + kBeside[b][0], y + kBeside[b][1], z + kBeside[b][2])) context |= std::size_t{1} << b;
          }
          if (coder.code(cell_models[context], source.at(x, y, z))) coded.set(x, y, z);
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
