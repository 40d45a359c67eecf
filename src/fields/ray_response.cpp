#include "fields/ray_response.h"

#include <algorithm>
#include <cmath>

#include "fields/field_batch.h"
#include "fields/ray_batch.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kG = FieldConfig::kGeometry;
constexpr std::size_t kSamples = 8;
constexpr std::size_t kPlaces = 7;    // of each ray: its own, then to either side along each axis
constexpr double kLeastOpacity = 0.5; // of what has a colour

Eigen::Vector3d displacement(std::size_t place, double step) {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  if (place > 0) shift[static_cast<Eigen::Index>((place - 1) / 2)] = place % 2 == 1 ? step : -step;
  return shift;
}

// Of the middle of a ray's sample.
double t_of(std::size_t sample, double reach) {
  return reach * (2 * (static_cast<double>(sample) + 0.5) / static_cast<double>(kSamples) - 1);
}

/// Samples of all rays at all their places.
class Samples {
public:
  Samples(const Field& field, std::span<const GridLevel> levels, std::span<const CanonicalRay> rays, double step)
      : field_(field), occupied_(rays.size() * kPlaces * kSamples) {
    for (std::vector<float>* axis : {&x_, &y_, &z_, &lengths_}) axis->reserve(occupied_.size());
    for (const CanonicalRay& ray : rays) {
      for (std::size_t place = 0; place < kPlaces; ++place) add(ray, displacement(place, step));
    }
    evaluate_points(field, levels, {x_.data(), y_.data(), z_.data(), x_.size()}, points_);
    std::vector<float> density(x_.size());
    passing_.resize(x_.size());
    kernels::densities(points_.geometry.data(), lengths_.data(), x_.size(), density.data(), passing_.data());
  }

  /// Of one ray at one place: opacity and t in the mean; the features' mean goes to `input`.
  std::array<double, 2> composite(std::size_t number, double reach, float* input) const {
    float transmittance = 1;
    double depth = 0;
    for (std::size_t s = 0; s < kSamples; ++s) {
      const std::size_t at = number * kSamples + s;
      if (!occupied_[at]) continue;
      const float weight = transmittance * (1 - passing_[at]);
      transmittance *= passing_[at];
      for (std::size_t f = 0; f + 1 < kG; ++f) input[f] += weight * points_.geometry[at * kG + f + 1];
      depth += static_cast<double>(weight) * t_of(s, reach);
    }
    const float opacity = 1 - transmittance;
    for (std::size_t f = 0; f + 1 < kG; ++f) input[f] /= opacity + kOpacityEpsilon;
    input[kG - 1] = 1;
    return {static_cast<double>(opacity), depth / static_cast<double>(opacity + kOpacityEpsilon)};
  }

private:
  void add(const CanonicalRay& ray, const Eigen::Vector3d& shift) {
    const FieldBox& box = field_.config.box;
    const int cells = field_.config.occupancy_resolution;
    const double length = 2 * ray.reach / static_cast<double>(kSamples) * ray.metres_per_t;
    for (std::size_t s = 0; s < kSamples; ++s) {
      const double t = t_of(s, ray.reach);
      const Eigen::Vector3d point = ray.point + t * ray.direction + t * t * ray.bends[t > 0 ? 1 : 0] + shift;
      Eigen::Vector3d place = (point - box.origin) / box.side;
      const bool inside = (place.array() >= 0).all() && (place.array() < 1).all();
      if (!inside) place.setZero(); // also where it is not a number
      const Eigen::Vector3i cell = (place * cells).cast<int>();
      occupied_[x_.size()] = inside && field_.occupancy.at(cell.x(), cell.y(), cell.z());
      x_.push_back(static_cast<float>(place.x()));
      y_.push_back(static_cast<float>(place.y()));
      z_.push_back(static_cast<float>(place.z()));
      lengths_.push_back(static_cast<float>(length / field_.config.density_length()));
    }
  }

  const Field& field_;
  std::vector<bool> occupied_;
  std::vector<float> x_, y_, z_, lengths_, passing_;
  PointBatch points_;
};

} // namespace

void respond(const Field& field, std::span<const GridLevel> levels, std::span<const CanonicalRay> rays,
             RayResponse* responses) {
  const double step = field.config.cell_size();
  const Samples samples(field, levels, rays, step);
  ColorBatch colors;
  colors.input.assign(rays.size() * kPlaces * kG, 0.0F);
  std::vector<std::array<double, RayResponse::kValues>> values(rays.size() * kPlaces);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto [opacity, depth] = samples.composite(k, rays[k / kPlaces].reach, colors.input.data() + k * kG);
    values[k][RayResponse::kOpacity] = opacity;
    values[k][RayResponse::kDepth] = depth;
  }
  evaluate_colors(field, values.size(), colors);
  for (std::size_t k = 0; k < values.size(); ++k) {
    for (std::size_t c = 0; c < RayResponse::kColors; ++c) {
      const auto output = static_cast<double>(colors.output[k * FieldConfig::kColorOutputs + c]);
      values[k][c] = 1 / (1 + std::exp(-output));
    }
  }
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto* at = &values[i * kPlaces];
    RayResponse& response = responses[i];
    response.value = at[0];
    response.is_opaque =
        std::all_of(at, at + kPlaces, [](const auto& v) { return v[RayResponse::kOpacity] > kLeastOpacity; });
    for (std::size_t v = 0; v < RayResponse::kValues; ++v) {
      for (std::size_t a = 0; a < 3; ++a) {
        response.by_place[v][static_cast<Eigen::Index>(a)] = (at[1 + 2 * a][v] - at[2 + 2 * a][v]) / (2 * step);
      }
    }
  }
}

} // namespace kinora::fields
