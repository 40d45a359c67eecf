#include "fields/training/ray_refinement.h"

#include <algorithm>

#include "fields/network/volume_density.h"

namespace kinora::fields {
namespace {

constexpr float kOpaque = 0.5F; // from that much on a band holds a surface
constexpr float kTransparent =
    0.05F; // up to that much it is empty, although its rays ask for a surface: others see through
// Shares of the way from the measured depth to the field's. The field errs where colours pull at it, so that what is
// measured remains what teaches depth.
constexpr float kSamplesMove = 0.75F;
constexpr float kTargetMoves = 0.25F;
constexpr float kNarrower = 0.5F;

/// First of a ray's samples that lie in the band; its end where nothing is measured.
std::size_t band_begin(const RayBatch& rays, std::size_t ray) {
  const RayTarget& target = rays.targets[ray];
  std::size_t begin = rays.first_sample[ray + 1];
  if (!target.foreground || target.depth <= 0) return begin;
  constexpr float kBand = -1.0001F; // rounding
  while (begin > rays.first_sample[ray] &&
         (rays.samples[begin - 1].depth - target.depth) * target.inverse_band > kBand) {
    --begin;
  }
  return begin;
}

/// The ray through a sample's neighbours, as straight as between them, at a depth.
std::array<float, 3> position_at(std::span<const RaySample> band, float depth) {
  std::size_t next = 1;
  while (next + 1 < band.size() && band[next].depth < depth) ++next;
  const RaySample& a = band[next - 1];
  const RaySample& b = band[next];
  const float along = (depth - a.depth) / (b.depth - a.depth);
  std::array<float, 3> position{};
  for (std::size_t i = 0; i < 3; ++i) position[i] = a.position[i] + along * (b.position[i] - a.position[i]);
  return position;
}

/// Spreads samples over the narrower band, each as far along its part as that of the band was which it comes from.
std::array<RaySample, kRefinedSamples> narrowed(std::span<const RaySample> band, const RayTarget& target, float move) {
  std::array<RaySample, kRefinedSamples> samples{};
  const float half = 1 / target.inverse_band;
  const float step = 2 * half / static_cast<float>(band.size());
  const float new_step = 2 * kNarrower * half / static_cast<float>(kRefinedSamples);
  const float begin = target.depth + kSamplesMove * move - kNarrower * half;
  for (std::size_t i = 0; i < kRefinedSamples; ++i) {
    const float along = (band[i].depth - target.depth + half) / step - static_cast<float>(i);
    const float depth = begin + new_step * (static_cast<float>(i) + along);
    samples[i] = {position_at(band, depth), depth, band[i].length * new_step / step};
  }
  return samples;
}

// Evaluates the samples in the bands of all measured rays.
void evaluate_bands(const Field& field, std::span<const GridLevel> levels, const RayBatch& rays,
                    RefinementScratch& scratch) {
  for (std::vector<float>* values : {&scratch.x, &scratch.y, &scratch.z, &scratch.length}) values->clear();
  for (std::size_t r = 0; r < rays.ray_count(); ++r) {
    for (std::size_t i = band_begin(rays, r); i < rays.first_sample[r + 1]; ++i) {
      const RaySample& sample = rays.samples[i];
      scratch.x.push_back(sample.position[0]);
      scratch.y.push_back(sample.position[1]);
      scratch.z.push_back(sample.position[2]);
      scratch.length.push_back(sample.length);
    }
  }
  const std::size_t n = scratch.x.size();
  scratch.density.resize(n);
  scratch.step_transmittance.resize(n);
  evaluate_points(field, levels, {scratch.x.data(), scratch.y.data(), scratch.z.data(), n}, scratch.points);
  kernels::densities(scratch.points.geometry.data(), scratch.length.data(), n, scratch.density.data(),
                     scratch.step_transmittance.data());
}

/// What the field holds in a ray's band.
struct SurfaceHit {
  float opacity = 0;
  float offset = 0; ///< metres from the measured depth to the mean depth at which the ray is met
};

SurfaceHit find_surface(std::span<const RaySample> band, const float* step_transmittance, float measured) {
  float transmittance = 1;
  float sum = 0;
  for (const RaySample& sample : band) {
    const float behind = transmittance * *step_transmittance++;
    sum += (transmittance - behind) * (sample.depth - measured);
    transmittance = behind;
  }
  return {1 - transmittance, transmittance < 1 ? sum / (1 - transmittance) : 0};
}

} // namespace

void refine_rays(const Field& field, std::span<const GridLevel> levels, RayBatch& rays, RefinementScratch& scratch) {
  evaluate_bands(field, levels, rays, scratch);
  const float* step_transmittance = scratch.step_transmittance.data();
  // Rays become fewer, and their samples: each is written where it or one before it was.
  std::size_t ray = 0;
  auto to = rays.samples.begin();
  for (std::size_t r = 0; r < rays.ray_count(); ++r) {
    const auto at = [&](std::size_t i) { return rays.samples.begin() + static_cast<std::ptrdiff_t>(i); };
    const auto first = at(rays.first_sample[r]);
    const auto band = at(band_begin(rays, r));
    const auto end = at(rays.first_sample[r + 1]);
    RayTarget target = rays.targets[r];
    const SurfaceHit hit = find_surface({band, end}, step_transmittance, target.depth);
    step_transmittance += end - band;
    const bool measured = band != end;
    if (measured && hit.opacity < kTransparent) continue;
    rays.first_sample[ray] = static_cast<std::uint32_t>(to - rays.samples.begin());
    if (static_cast<std::size_t>(end - band) < kRefinedSamples || hit.opacity < kOpaque) {
      to = std::copy(first, end, to);
    } else {
      const auto samples = narrowed({band, end}, target, hit.offset);
      to = std::copy(first, band, to);
      to = std::copy(samples.begin(), samples.end(), to);
      target.depth += kTargetMoves * hit.offset;
    }
    rays.targets[ray++] = target;
  }
  rays.targets.resize(ray);
  rays.first_sample.resize(ray + 1);
  rays.first_sample.back() = static_cast<std::uint32_t>(to - rays.samples.begin());
  rays.samples.erase(to, rays.samples.end());
}

} // namespace kinora::fields
