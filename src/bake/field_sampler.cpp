#include "bake/field_sampler.h"

#include <cmath>

#include "fields/model/enclosed_cells.h"
#include "fields/network/field_batch.h"
#include "fields/network/ray_batch.h"
#include "fields/network/volume_density.h"

namespace kinora::bake {
namespace {

constexpr std::size_t kG = fields::FieldConfig::kGeometry;
constexpr std::size_t kF = FieldSamples::kFeatures;

bool is_in(const fields::Occupancy& cells, const fields::FieldBox& box, const Eigen::Vector3d& canonical) {
  const int n = cells.resolution();
  const Eigen::Vector3d cell = (canonical - box.origin) * (n / box.side);
  if (!((cell.array() >= 0).all() && (cell.array() < n).all())) return false;
  return cells.at(static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z()));
}

} // namespace

FieldSampler::FieldSampler(const fields::Field& field)
    : field_(&field), enclosed_(fields::enclosed_cells(field.occupancy)), levels_(fields::grid_levels(field.config)) {}

bool FieldSampler::occupied(const Eigen::Vector3d& canonical) const {
  const fields::FieldBox& box = field_->config.box;
  return is_in(field_->occupancy, box, canonical) || is_in(enclosed_, box, canonical);
}

void FieldSampler::evaluate(std::span<const Eigen::Vector3d> canonical, FieldSamples& samples) const {
  samples.density.assign(canonical.size(), 0.0F);
  samples.features.resize(canonical.size());
  const fields::FieldBox& box = field_->config.box;
  const float per_metre = 1.0F / static_cast<float>(field_->config.density_length());
  std::vector<std::size_t> inside;
  std::array<std::vector<float>, 3> coordinates;
  for (std::size_t i = 0; i < canonical.size(); ++i) {
    if (is_in(enclosed_, box, canonical[i])) samples.density[i] = std::exp(fields::kMaxRawDensity) * per_metre;
    if (!is_in(field_->occupancy, box, canonical[i])) continue;
    inside.push_back(i);
    const Eigen::Vector3f p = ((canonical[i] - box.origin) / box.side).cast<float>();
    for (std::size_t a = 0; a < 3; ++a) coordinates[a].push_back(p[static_cast<Eigen::Index>(a)]);
  }
  if (inside.empty()) return;
  fields::PointBatch batch;
  fields::evaluate_points(*field_, levels_,
                          {coordinates[0].data(), coordinates[1].data(), coordinates[2].data(), inside.size()}, batch);
  for (std::size_t k = 0; k < inside.size(); ++k) {
    const float* g = batch.geometry.data() + k * kG;
    samples.density[inside[k]] = std::exp(std::min(g[0], fields::kMaxRawDensity)) * per_metre;
    std::copy_n(g + 1, kF, samples.features[inside[k]].begin());
  }
}

std::vector<std::array<float, 3>>
FieldSampler::colors(std::span<const std::array<float, FieldSamples::kFeatures>> features) const {
  std::vector<std::array<float, 3>> colors(features.size());
  if (features.empty()) return colors;
  fields::ColorBatch batch;
  batch.input.resize(features.size() * kG);
  for (std::size_t i = 0; i < features.size(); ++i) {
    std::copy_n(features[i].begin(), kF, batch.input.data() + i * kG);
    batch.input[i * kG + kF] = 1;
  }
  fields::evaluate_colors(*field_, features.size(), batch);
  for (std::size_t i = 0; i < features.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      colors[i][c] = 1.0F / (1.0F + std::exp(-batch.output[i * fields::FieldConfig::kColorOutputs + c]));
    }
  }
  return colors;
}

} // namespace kinora::bake
