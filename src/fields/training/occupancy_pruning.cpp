#include "fields/training/occupancy_pruning.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/parallel.h"
#include "core/random.h"
#include "fields/network/field_batch.h"
#include "fields/network/ray_batch.h"
#include "fields/network/volume_density.h"

namespace kinora::fields {

void prune_occupancy(Field& field) {
  constexpr float kVisible = 0.02F;
  const auto r = static_cast<std::size_t>(field.config.occupancy_resolution);
  const auto cells_per_side = static_cast<float>(r);
  const auto cell = static_cast<float>(field.config.box.side / field.config.density_length()) / cells_per_side;
  const std::vector<GridLevel> levels = grid_levels(field.config);
  std::vector<std::uint64_t>& words = field.occupancy.words();
  parallel_for(words.size(), 256, [&](const Chunk& chunk) {
    std::vector<std::size_t> candidates;
    for (std::size_t w = chunk.begin; w < chunk.end; ++w) {
      for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1) {
        candidates.push_back(w * 64 + static_cast<std::size_t>(std::countr_zero(bits)));
      }
      words[w] = 0;
    }
    std::vector<float> x, y, z;
    PointBatch batch;
    Random random(0x9A11, chunk.index);
    for (const std::size_t probes : {2, 6}) { // most show something at one of the first two
      for (std::vector<float>* values : {&x, &y, &z}) values->clear();
      for (const std::size_t index : candidates) {
        const std::size_t cell_x = index % r;
        const std::size_t cell_y = index / r % r;
        const std::size_t cell_z = index / (r * r);
        for (std::size_t k = 0; k < probes; ++k) {
          x.push_back((static_cast<float>(cell_x) + random.uniform()) / cells_per_side);
          y.push_back((static_cast<float>(cell_y) + random.uniform()) / cells_per_side);
          z.push_back((static_cast<float>(cell_z) + random.uniform()) / cells_per_side);
        }
      }
      evaluate_points(field, levels, {x.data(), y.data(), z.data(), x.size()}, batch);
      std::size_t left = 0;
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        float densest = 0;
        for (std::size_t k = 0; k < probes; ++k) {
          const float raw = batch.geometry[(i * probes + k) * FieldConfig::kGeometry];
          densest = std::max(densest, std::exp(std::min(raw, kMaxRawDensity)));
        }
        if (1 - std::exp(-densest * cell) < kVisible) {
          candidates[left++] = candidates[i];
        } else {
          words[candidates[i] >> 6] |= std::uint64_t{1} << (candidates[i] & 63);
        }
      }
      candidates.resize(left);
    }
  });
}

} // namespace kinora::fields
