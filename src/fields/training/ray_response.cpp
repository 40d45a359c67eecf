#include "fields/training/ray_response.h"

#include <algorithm>
#include <cmath>

#include "fields/network/field_batch.h"
#include "fields/network/ray_batch.h"
#include "fields/network/volume_density.h"
#include "fields/training/ray_refinement.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kG = FieldConfig::kGeometry;
/// As far apart as those of refined rays, which lie in half the band: with others, surfaces lie elsewhere
/// (docs/experiments/sharpness.md).
constexpr std::size_t kSamples = 2 * kRefinedSamples;
constexpr std::size_t kDisplacements = 7; // of each ray: its own, then to either side along each axis
constexpr double kMinOpacity = 0.5;       // of what has a colour

Eigen::Vector3d displacement(std::size_t displacement_index, double step) {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  if (displacement_index > 0)
    shift[static_cast<Eigen::Index>((displacement_index - 1) / 2)] = displacement_index % 2 == 1 ? step : -step;
  return shift;
}

// Of a ray's sample; rays have theirs at other places, evenly spread, so that none of them matters to all.
double t_of(std::size_t ray, std::size_t sample, double reach) {
  constexpr double kGolden = 0.6180339887498949;
  const double offset = static_cast<double>(ray) * kGolden;
  const double at = static_cast<double>(sample) + offset - std::floor(offset);
  return reach * (2 * at / static_cast<double>(kSamples) - 1);
}

/// Samples of all rays at all their places; those in empty space let all light pass.
class Samples {
public:
  Samples(const Field& field, std::span<const GridLevel> levels, std::span<const CanonicalRay> rays,
          std::size_t displacements, double step)
      : field_(field) {
    for (std::vector<float>* axis : {&x_, &y_, &z_, &lengths_}) axis->reserve(rays.size() * displacements * kSamples);
    first_.reserve(rays.size() * displacements + 1);
    for (std::size_t r = 0; r < rays.size(); ++r) {
      for (std::size_t displacement_index = 0; displacement_index < displacements; ++displacement_index)
        add(r, rays[r], displacement(displacement_index, step));
    }
    first_.push_back(x_.size());
    evaluate_points(field, levels, {x_.data(), y_.data(), z_.data(), x_.size()}, points_);
    std::vector<float> density(x_.size());
    transmittance_.resize(x_.size());
    kernels::densities(points_.geometry.data(), lengths_.data(), x_.size(), density.data(), transmittance_.data());
  }

  /// Of one ray at one place: opacity and t in the mean; the features' mean goes to `input`.
  std::array<double, 2> composite(std::size_t number, float* input) const {
    float transmittance = 1;
    float depth = 0;
    for (std::size_t i = first_[number]; i < first_[number + 1]; ++i) {
      const float weight = transmittance * (1 - transmittance_[i]);
      transmittance *= transmittance_[i];
      for (std::size_t f = 0; f + 1 < kG; ++f) input[f] += weight * points_.geometry[i * kG + f + 1];
      depth += weight * t_[i];
    }
    const float opacity = 1 - transmittance;
    const float normaliser = 1 / (opacity + kOpacityEpsilon);
    for (std::size_t f = 0; f + 1 < kG; ++f) input[f] *= normaliser;
    input[kG - 1] = 1;
    return {static_cast<double>(opacity), static_cast<double>(depth * normaliser)};
  }

private:
  void add(std::size_t number, const CanonicalRay& ray, const Eigen::Vector3d& shift) {
    const FieldBox& box = field_.config.box;
    const int cells = field_.config.occupancy_resolution;
    const double length = 2 * ray.reach / static_cast<double>(kSamples) * ray.metres_per_t;
    first_.push_back(x_.size());
    for (std::size_t s = 0; s < kSamples; ++s) {
      const double t = t_of(number, s, ray.reach);
      const Eigen::Vector3d point = ray.point + t * ray.direction + t * t * ray.curvatures[t > 0 ? 1 : 0] + shift;
      const Eigen::Vector3d position = (point - box.origin) / box.side;
      if (!((position.array() >= 0).all() && (position.array() < 1).all())) continue; // or not a number
      const Eigen::Vector3i cell = (position * cells).cast<int>();
      if (!field_.occupancy.at(cell.x(), cell.y(), cell.z())) continue;
      x_.push_back(static_cast<float>(position.x()));
      y_.push_back(static_cast<float>(position.y()));
      z_.push_back(static_cast<float>(position.z()));
      t_.push_back(static_cast<float>(t));
      lengths_.push_back(static_cast<float>(length / field_.config.density_length()));
    }
  }

  const Field& field_;
  std::vector<std::size_t> first_; ///< sample of each ray at each place; one more at the end
  std::vector<float> x_, y_, z_, t_, lengths_, transmittance_;
  PointBatch points_;
};

} // namespace

void respond(const Field& field, std::span<const GridLevel> levels, std::span<const CanonicalRay> rays, bool jacobian,
             RayResponse* responses) {
  const double step = field.config.cell_size();
  const std::size_t displacements = jacobian ? kDisplacements : 1;
  const Samples samples(field, levels, rays, displacements, step);
  ColorBatch colors;
  colors.input.assign(rays.size() * displacements * kG, 0.0F);
  std::vector<std::array<double, RayResponse::kValues>> values(rays.size() * displacements);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto [opacity, depth] = samples.composite(k, colors.input.data() + k * kG);
    values[k][RayResponse::kOpacity] = opacity;
    values[k][RayResponse::kDepth] = depth;
    rotate_vectors(rays[k / displacements].rotation, colors.input.data() + k * kG);
  }
  evaluate_colors(field, values.size(), colors);
  for (std::size_t k = 0; k < values.size(); ++k) {
    for (std::size_t c = 0; c < RayResponse::kColors; ++c) {
      const auto output = static_cast<double>(colors.output[k * FieldConfig::kColorOutputs + c]);
      values[k][c] = 1 / (1 + std::exp(-output));
    }
  }
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto* at = &values[i * displacements];
    RayResponse& response = responses[i];
    response.value = at[0];
    const auto is_opaque = [](const auto& displaced_values) {
      return displaced_values[RayResponse::kOpacity] > kMinOpacity;
    };
    response.is_opaque = is_opaque(at[0]);
    response.jacobian.fill(Eigen::Vector3d::Zero());
    if (!jacobian) continue;
    const bool all_opaque = std::all_of(at, at + displacements, is_opaque);
    for (std::size_t v = 0; v < RayResponse::kValues; ++v) {
      if (!all_opaque && v != RayResponse::kOpacity) continue;
      for (std::size_t a = 0; a < 3; ++a) {
        response.jacobian[v][static_cast<Eigen::Index>(a)] = (at[1 + 2 * a][v] - at[2 + 2 * a][v]) / (2 * step);
      }
    }
  }
}

} // namespace kinora::fields
