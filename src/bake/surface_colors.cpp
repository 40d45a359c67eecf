#include "bake/surface_colors.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "fields/network/vector_features.h"

namespace kinora::bake {
namespace {

using Features = std::array<float, FieldSamples::kFeatures>;

constexpr int kBehind = 6; ///< samples from the point on, one per cell
constexpr int kMinBefore = 2;

/// Frames spread over the clip, in whose light a layer is seen.
std::vector<motion::Warp> sampled_warps(const motion::Motion& motion) {
  constexpr std::size_t kFrames = 8;
  std::vector<int> seen;
  for (std::size_t f = 0; f < std::max(motion.poses().size(), motion.deformations().size()); ++f) {
    if (motion.health(f) == motion::Health::kTracked) seen.push_back(static_cast<int>(f));
  }
  if (seen.empty()) seen = {0};
  const std::size_t count = std::min(kFrames, seen.size());
  std::vector<motion::Warp> warps;
  for (std::size_t k = 0; k < count; ++k) warps.push_back(motion.warp(seen[(2 * k + 1) * seen.size() / (2 * count)]));
  return warps;
}

fields::Rotation rotation_at(const motion::Warp& warp, const Eigen::Vector3d& canonical) {
  if (warp.is_rigid()) return fields::rotation_of(warp.rigid().linear());
  const auto pose = warp.at(canonical);
  return pose ? fields::rotation_of(pose->linear()) : fields::kNoRotation;
}

/// Features composited along a short ray through the surface, as the renderer does.
std::vector<Features> composited(const FieldSampler& sampler, std::span<const SurfacePoint> points, int before) {
  const double step = sampler.field().config.cell_size();
  const auto count = static_cast<std::size_t>(before) + static_cast<std::size_t>(kBehind);
  std::vector<Eigen::Vector3d> places;
  places.reserve(points.size() * count);
  for (const SurfacePoint& point : points) {
    for (int k = -before; k < kBehind; ++k) places.emplace_back(point.position - k * step * point.normal);
  }
  FieldSamples samples;
  sampler.evaluate(places, samples);
  std::vector<Features> features(points.size());
  for (std::size_t v = 0; v < features.size(); ++v) {
    float transmittance = 1;
    for (std::size_t k = v * count; k < (v + 1) * count; ++k) {
      const float behind = transmittance * std::exp(-samples.density[k] * static_cast<float>(step));
      for (std::size_t f = 0; f < FieldSamples::kFeatures; ++f)
        features[v][f] += (transmittance - behind) * samples.features[k][f];
      transmittance = behind;
    }
    for (float& f : features[v]) f /= std::max(1 - transmittance, 1e-6F);
  }
  return features;
}

void color_points(const FieldSampler& sampler, std::span<const motion::Warp> warps,
                  std::span<const SurfacePoint> points, int before, std::span<std::array<std::uint8_t, 3>> colors) {
  const std::vector<Features> features = composited(sampler, points, before);
  std::vector<Eigen::Array3f> sums(features.size(), Eigen::Array3f::Zero());
  for (const motion::Warp& warp : warps) {
    auto rotated = features;
    for (std::size_t v = 0; v < features.size(); ++v)
      fields::rotate_vectors(rotation_at(warp, points[v].position), rotated[v].data());
    const auto shaded = sampler.colors(rotated);
    for (std::size_t v = 0; v < features.size(); ++v) sums[v] += Eigen::Map<const Eigen::Array3f>(shaded[v].data());
  }
  for (std::size_t v = 0; v < features.size(); ++v) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float mean = sums[v][static_cast<Eigen::Index>(c)] / static_cast<float>(warps.size());
      colors[v][c] = static_cast<std::uint8_t>(std::lround(255 * mean));
    }
  }
}

} // namespace

std::vector<std::array<std::uint8_t, 3>> surface_colors(const FieldSampler& sampler, const motion::Motion& motion,
                                                        std::span<const SurfacePoint> points, double before,
                                                        const Progress& progress) {
  const int samples_before =
      std::max(kMinBefore, static_cast<int>(std::ceil(before / sampler.field().config.cell_size())));
  const std::vector<motion::Warp> warps = sampled_warps(motion);
  std::vector<std::array<std::uint8_t, 3>> colors(points.size());
  parallel_for(points.size(), 2048, [&](const Chunk& chunk) {
    progress.check();
    const std::size_t count = chunk.end - chunk.begin;
    color_points(sampler, warps, points.subspan(chunk.begin, count), samples_before,
                 std::span(colors).subspan(chunk.begin, count));
  });
  return colors;
}

} // namespace kinora::bake
