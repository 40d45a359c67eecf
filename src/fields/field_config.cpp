// Model size by need: a field's box, resolution and tables from the surface that was seen.
#include "fields/trainer.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.h"

namespace kinora::fields {
namespace {

struct Observation {
  std::vector<Eigen::Vector3d> points; // canonical, metres
  std::vector<double> footprints;      // metres of a pixel at the point
};

// A spread of at most about `kPoints` measured pixels of the layer.
Observation observe(const PixelStore& store, int label, const tracking::Motion& motion) {
  constexpr std::size_t kPoints = 400'000;
  const auto wanted = [&](const StoredPixel& pixel) { return pixel.label == label && pixel.depth > 0; };
  const std::size_t all = static_cast<std::size_t>(std::count_if(store.pixels().begin(), store.pixels().end(), wanted));
  const std::size_t stride = std::max<std::size_t>(1, all / kPoints);
  Observation seen;
  std::size_t found = 0;
  for (const StoredFrame& frame : store.frames()) {
    if (motion.health(static_cast<std::size_t>(frame.frame)) == tracking::Health::kLost) continue;
    const tracking::Warp warp = motion.warp(frame.frame);
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const StoredPixel& pixel = store.pixels()[i];
      if (!wanted(pixel) || found++ % stride != 0) continue;
      const Eigen::Vector3d in_camera = frame.camera.intrinsics.unproject(pixel.u, pixel.v, pixel.depth);
      const auto canonical = warp.to_canonical(frame.camera.camera_to_world * in_camera);
      if (!canonical) continue;
      seen.points.push_back(*canonical);
      seen.footprints.push_back(pixel.depth / frame.camera.intrinsics.fx);
    }
  }
  return seen;
}

double quantile(std::vector<double> values, double q) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

FieldBox box_around(const std::vector<Eigen::Vector3d>& points, double margin) {
  // A few stray measurements do not enlarge the box.
  constexpr double kStray = 0.0005;
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  for (int a = 0; a < 3; ++a) {
    std::vector<double> values(points.size());
    std::transform(points.begin(), points.end(), values.begin(), [a](const auto& p) { return p[a]; });
    low[a] = quantile(values, kStray) - margin;
    high[a] = quantile(values, 1 - kStray) + margin;
  }
  const double side = (high - low).maxCoeff();
  return {0.5 * (low + high) - Eigen::Vector3d::Constant(0.5 * side), side};
}

// Cells of a grid of the given size that hold a point.
std::size_t touched_cells(const std::vector<Eigen::Vector3d>& points, const FieldBox& box, int resolution) {
  Occupancy cells(resolution);
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d c = (p - box.origin) / box.side * resolution;
    if ((c.array() < 0).any() || (c.array() >= resolution).any()) continue;
    cells.set(static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z()));
  }
  return cells.count();
}

} // namespace

FieldConfig choose_field_config(const PixelStore& pixels, int label, const tracking::Motion& motion) {
  const Observation seen = observe(pixels, label, motion);
  if (seen.points.empty()) {
    throw Error(ErrorCode::kFailure, "a layer without any measured pixel cannot be modelled");
  }
  FieldConfig config;
  const double footprint = quantile(seen.footprints, 0.25);
  const double margin = std::max(4 * footprint, 0.02);
  config.box = box_around(seen.points, margin);
  const double wanted = config.box.side / footprint;
  config.finest_resolution = static_cast<int>(std::clamp(wanted, 64.0, 2048.0));
  config.occupancy_resolution = config.finest_resolution > 1024 ? 256 : (config.finest_resolution >= 192 ? 128 : 64);
  config.levels = config.finest_resolution > 1024 ? 6 : 4;
  // A surface at resolution r touches about s·r² cells; s is measured at a resolution that the points can fill.
  constexpr int kProbe = 64;
  const double share = static_cast<double>(touched_cells(seen.points, config.box, kProbe)) / (kProbe * kProbe);
  const double finest = share * config.finest_resolution * config.finest_resolution;
  const int log2_entries = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(std::max(finest, 1.0))));
  // Parameters, gradients and moments of a layer stay below 16 MB, near to the processor.
  config.log2_table_size = std::clamp(log2_entries, 13, config.levels > 4 ? 14 : 15);
  return config;
}

} // namespace kinora::fields
