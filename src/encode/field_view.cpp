#include "encode/field_view.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/statistics.h"
#include "fields/sampling/contour_pixels.h"
#include "fields/sampling/surface_band.h"

namespace kinora::encode {
namespace {

using fields::RayResponse;

constexpr std::size_t kPixels = 4000;        // of a frame
constexpr std::size_t kContourPixels = 3000; // besides, on either side of the rim
constexpr std::size_t kMinPixels = 100;      // pixels with colour that a frame must have
constexpr std::size_t kRaysPerChunk = 128;
// Neighbouring pixels are not independent: what a row weighs.
constexpr double kShare = 0.3;
constexpr double kOpacitySigma = 0.3;
constexpr double kMinColorSigma = 0.01;
constexpr double kMaxDeviations = 3; // a residual costs no more than so many

} // namespace

FieldView::FieldView(const fields::Field& field, const fields::LayerObservations& layer,
                     const fields::StoredFrame& frame)
    : field_(field), levels_(fields::grid_levels(field.config)), pixels_(layer.pixels), frame_(frame) {
  choose_probes(layer);
  responses_.resize(probes_.size());
  positions_.resize(probes_.size());
}

void FieldView::choose_probes(const fields::LayerObservations& layer) {
  std::vector<Probe> foreground;
  for (std::size_t i = frame_.begin; i < frame_.end; ++i) {
    const fields::StoredPixel& pixel = pixels_.pixels()[i];
    if (layer.is_foreground(pixel) && pixel.depth.is_known()) {
      foreground.push_back({static_cast<std::uint32_t>(i), pixel.depth.metres(), true, false});
    }
  }
  const auto spread = [&](std::size_t count, std::size_t max_count, const auto& probe_of) {
    const std::size_t stride = (count + max_count - 1) / max_count;
    for (std::size_t i = stride / 2; i < count; i += stride) probes_.push_back(probe_of(i));
  };
  const fields::ContourPixels contour = fields::contour_pixels(layer, frame_, field_.config);
  const auto of_contour = [](const fields::ContourPixel& pixel, bool is_foreground) {
    return Probe{pixel.pixel, pixel.depth, is_foreground, true};
  };
  spread(foreground.size(), kPixels, [&](std::size_t i) { return foreground[i]; });
  spread(contour.inside.size(), kContourPixels, [&](std::size_t i) { return of_contour(contour.inside[i], true); });
  spread(contour.outside.size(), kContourPixels, [&](std::size_t i) { return of_contour(contour.outside[i], false); });
}

void FieldView::evaluate(bool jacobian, const ToCanonical& to_canonical) {
  const SE3& to_world = frame_.camera.camera_to_world;
  parallel_for(probes_.size(), kRaysPerChunk, [&](const Chunk& chunk) {
    std::vector<Ray> rays;
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const fields::StoredPixel& pixel = pixels_.pixels()[probes_[i].pixel];
      const RowRay ray = frame_.ray(pixel);
      const Eigen::Vector3d direction = to_world.linear() * ray.direction;
      rays.push_back({to_world * ray.origin + probes_[i].depth * direction, direction,
                      fields::surface_band(field_.config, probes_[i].depth)});
    }
    std::vector<fields::CanonicalRay> canonical(rays.size());
    to_canonical(rays, canonical.data());
    respond(field_, levels_, canonical, jacobian, responses_.data() + chunk.begin);
    for (std::size_t k = 0; k < rays.size(); ++k) {
      const double depth = responses_[chunk.begin + k].value[RayResponse::kDepth];
      positions_[chunk.begin + k] = canonical[k].point + depth * canonical[k].direction;
    }
  });
}

std::optional<double> FieldView::residual(std::size_t i, std::size_t value) const {
  const fields::StoredPixel& pixel = pixels_.pixels()[probes_[i].pixel];
  const RayResponse& response = responses_[i];
  if (!positions_[i].allFinite()) return std::nullopt;
  if (value == RayResponse::kOpacity) return response.value[value] - (probes_[i].foreground ? 1.0 : 0.0);
  if (!has_color(i)) return std::nullopt;
  if (value == RayResponse::kDepth)
    return pixel.depth.is_measured() ? std::optional(response.value[value]) : std::nullopt;
  return response.value[value] - pixel.color[value] / 255.0;
}

double FieldView::weight(std::size_t i, std::size_t value, double color_sigma) const {
  const double sigma = value == RayResponse::kOpacity ? kOpacitySigma
                       : value == RayResponse::kDepth ? kSensorNoise.sigma(probes_[i].depth)
                                                      : color_sigma;
  return std::sqrt(kShare) / sigma;
}

std::optional<double> FieldView::color_sigma() const {
  std::vector<double> sizes;
  for (std::size_t i = 0; i < size(); ++i) {
    if (probes_[i].on_contour || !has_color(i)) continue;
    for (std::size_t c = 0; c < RayResponse::kColors; ++c) sizes.push_back(std::abs(*residual(i, c)));
  }
  if (sizes.size() < RayResponse::kColors * kMinPixels) return std::nullopt;
  return std::max(kMinColorSigma, kDeviationPerMedian * median(sizes));
}

double FieldView::cost(double color_sigma) const {
  double sum = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    for (std::size_t v = 0; v < RayResponse::kValues; ++v) {
      if (v == RayResponse::kDepth) continue;
      const auto difference = residual(i, v);
      if (!difference && !probes_[i].foreground) continue;
      const double max_cost = kShare * kMaxDeviations * kMaxDeviations;
      const double deviations = difference ? *difference * weight(i, v, color_sigma) : max_cost;
      sum += std::min(deviations * deviations, max_cost);
    }
  }
  return sum;
}

} // namespace kinora::encode
