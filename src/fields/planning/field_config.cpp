// Model size by need: a field's box, resolution and tables from the surface that was seen.
#include "fields/training/trainer.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.h"
#include "fields/sampling/layer_points.h"

namespace kinora::fields {
namespace {

double quantile(std::vector<double> values, double q) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

FieldBox box_around(const std::vector<LayerPoint>& points, double margin) {
  // A few stray measurements do not enlarge the box.
  constexpr double kOutliers = 0.0005;
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  for (int a = 0; a < 3; ++a) {
    std::vector<double> values(points.size());
    std::transform(points.begin(), points.end(), values.begin(), [a](const auto& p) { return p.canonical[a]; });
    low[a] = quantile(values, kOutliers) - margin;
    high[a] = quantile(values, 1 - kOutliers) + margin;
  }
  const double side = (high - low).maxCoeff();
  return {0.5 * (low + high) - Eigen::Vector3d::Constant(0.5 * side), side};
}

// Cells of a grid of the given size that hold a point.
std::size_t touched_cells(const std::vector<LayerPoint>& points, const FieldBox& box, int resolution) {
  Occupancy cells(resolution);
  for (const LayerPoint& point : points) {
    const Eigen::Vector3d c = (point.canonical - box.origin) / box.side * resolution;
    if ((c.array() < 0).any() || (c.array() >= resolution).any()) continue;
    cells.set(static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z()));
  }
  return cells.count();
}

} // namespace

FieldConfig choose_field_config(const LayerObservations& layer, FieldRequirements* requirements) {
  constexpr std::size_t kPoints = 400'000;
  const std::vector<LayerPoint> observed = measured_and_extended_points(layer, kPoints);
  if (observed.empty()) {
    throw Error(ErrorCode::kFailure, "a layer without any measured pixel cannot be modelled");
  }
  FieldConfig config;
  std::vector<double> footprints(observed.size());
  std::transform(observed.begin(), observed.end(), footprints.begin(),
                 [](const auto& point) { return point.footprint; });
  const double footprint = quantile(std::move(footprints), 0.25);
  const double margin = std::max(4 * footprint, 0.02);
  config.box = box_around(observed, margin);
  const double wanted_resolution = config.box.side / footprint;
  config.finest_resolution = static_cast<int>(std::clamp(wanted_resolution, 64.0, 2048.0));
  config.occupancy_resolution = config.finest_resolution > 1024 ? 256 : (config.finest_resolution >= 192 ? 128 : 64);
  config.levels = config.finest_resolution > 1024 ? 6 : 4;
  // A surface at resolution r touches about s·r² cells; s is measured at a resolution that the points can fill.
  constexpr int kProbeResolution = 64;
  const double share = static_cast<double>(touched_cells(observed, config.box, kProbeResolution)) /
                       (kProbeResolution * kProbeResolution);
  const double finest = share * config.finest_resolution * config.finest_resolution;
  const int log2_entries = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(std::max(finest, 1.0))));
  // Parameters, gradients and moments of a layer stay below 16 MB, near to the processor.
  config.log2_table_size = std::clamp(log2_entries, 13, config.levels > 4 ? 14 : 15);
  if (requirements != nullptr) *requirements = {observed.size(), footprint, finest};
  return config;
}

} // namespace kinora::fields
