#include "fields/sampling/ray_sampler.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"
#include "fields/sampling/morton_order.h"

namespace kinora::fields {
namespace {

constexpr std::size_t kObservationsPerColumn = 16;

// About an exact depth (docs/experiments/fields.md).
constexpr float kCloseBand = 0.3F;
constexpr int kCloseSamples = 3;

// Takes every so many-th of a list, at most about four thousand, and leaves the others in order.
template <class Rays, class Take> void take_every_nth(Rays& rays, const Take& take) {
  constexpr std::size_t kMaxTaken = 4096;
  constexpr std::size_t kMinStride = 32;
  const std::size_t stride = std::max(kMinStride, rays.size() / kMaxTaken);
  std::size_t left = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (i % stride == stride - 1) {
      take(rays[i]);
    } else {
      rays[left++] = rays[i];
    }
  }
  rays.resize(left);
}

} // namespace

RaySampler::RaySampler(const LayerObservations& layer, const FieldConfig& config, const SamplingConfig& sampling,
                       SensorNoise noise)
    : layer_(layer), config_(config), sampling_(sampling), noise_(noise),
      per_density_length_(static_cast<float>(1 / config.density_length())), min_band_(min_band(config)),
      occupancy_(config.occupancy_resolution) {
  if (std::max({sampling.free_samples + sampling.surface_samples, sampling.unmeasured_samples,
                sampling.free_space_ray_samples}) > static_cast<int>(RayPoints::kMaxPoints)) {
    throw Error(ErrorCode::kUsage, fmt::format("a ray has at most {} samples", RayPoints::kMaxPoints));
  }
  if (layer.deforms()) {
    warped_foreground_ = warp_measured_pixels(layer, config, noise);
    arrange(warped_foreground_, [](const WarpedPixel& foreground) { return foreground; });
  } else {
    list_foreground();
    arrange(foreground_, [this](const PixelRef& foreground) { return full_ray(foreground); });
  }
  occupied_.emplace(occupancy_);
  space_ = observe_occupied_space(layer, config, occupancy_, sampling.near_depth, noise);
}

void RaySampler::list_foreground() {
  for (const StoredFrame& stored : layer_.pixels.frames()) frames_.push_back(frame_rays(stored));
  foreground_.reserve(layer_.pixels.pixels().size());
  for (std::uint32_t f = 0; f < layer_.pixels.frames().size(); ++f) {
    const StoredFrame& stored = layer_.pixels.frames()[f];
    if (layer_.is_lost(stored)) continue;
    for (std::size_t i = stored.begin; i < stored.end; ++i) {
      const StoredPixel& pixel = stored_pixel(static_cast<std::uint32_t>(i));
      if (layer_.is_foreground(pixel) && pixel.depth.is_known())
        foreground_.push_back({f, static_cast<std::uint32_t>(i)});
    }
  }
}

// Sorts measured pixels by what they see, marks that space as occupied and holds some of them apart.
template <class Rays, class FullRay> void RaySampler::arrange(Rays& rays, const FullRay& full_ray_of) {
  const std::vector<std::size_t> ends = sort_by_morton_code(rays, [&](const auto& foreground) {
    const WarpedPixel ray = full_ray_of(foreground);
    return point_at(ray.ray, stored_pixel(ray.pixel).depth.metres());
  });
  // A place is looked at again and again, from much the same sides: so many looks for each column of its cells tell
  // all.
  const auto columns = static_cast<std::size_t>(std::max(occupancy_.resolution() / static_cast<int>(kOrderCells), 1));
  const std::size_t max_observations = kObservationsPerColumn * columns * columns;
  parallel_for(ends.size(), 4096, [&](const Chunk& chunk) {
    for (std::size_t cell = chunk.begin; cell < chunk.end; ++cell) {
      const std::size_t begin = cell == 0 ? 0 : ends[cell - 1];
      const std::size_t count = ends[cell] - begin;
      const std::size_t observations = std::min(count, max_observations);
      for (std::size_t k = 0; k < observations; ++k) mark(full_ray_of(rays[begin + k * count / observations]));
    }
  });
  take_every_nth(rays, [&](const auto& foreground) { validation_rays_.push_back(full_ray_of(foreground)); });
}

void RaySampler::mark(const WarpedPixel& foreground) {
  const float depth = stored_pixel(foreground.pixel).depth.metres();
  const float band = band_at(depth);
  mark_occupied(occupancy_, foreground.ray, {depth - band, depth + band});
}

RaySampler::FrameRays RaySampler::frame_rays(const StoredFrame& frame) const {
  const SE3 canonical_from_camera =
      layer_.motion.canonical_to_world(frame.frame).inverse() * frame.camera.camera_to_world;
  const Intrinsics& k = frame.camera.intrinsics;
  FrameRays rays{};
  Eigen::Map<Eigen::Vector3f>(rays.origin.data()) =
      ((canonical_from_camera.translation() - config_.box.origin) / config_.box.side).cast<float>();
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(rays.camera_to_box.data()) =
      (canonical_from_camera.linear() / config_.box.side).cast<float>();
  rays.per_fx = static_cast<float>(1 / k.fx);
  rays.per_fy = static_cast<float>(1 / k.fy);
  rays.cx = static_cast<float>(k.cx);
  rays.cy = static_cast<float>(k.cy);
  rays.per_height = 1 / static_cast<float>(k.height);
  Eigen::Map<Eigen::Matrix<float, 6, 1>>(rays.readout.data()) = frame.readout.cast<float>();
  rays.rotation = packed(rotation_of(layer_.motion.canonical_to_world(frame.frame).linear()));
  return rays;
}

FieldRay RaySampler::ray_of(const PixelRef& ref) const {
  const FrameRays& frame = frames_[ref.frame];
  const StoredPixel& pixel = stored_pixel(ref.pixel);
  const float x = (static_cast<float>(pixel.u) - frame.cx) * frame.per_fx;
  const float y = (static_cast<float>(pixel.v) - frame.cy) * frame.per_fy;
  const float time = (static_cast<float>(pixel.v) + 0.5F) * frame.per_height - 0.5F; // row_time()
  const std::array<float, 6>& m = frame.readout;
  const std::array<float, 3> direction = {x + time * (m[4] - m[5] * y), y + time * (m[5] * x - m[3]),
                                          1 + time * (m[3] * y - m[4] * x)};
  FieldRay ray{};
  for (std::size_t a = 0; a < 3; ++a) {
    const float* to_box = &frame.camera_to_box[3 * a];
    ray.origin[a] = frame.origin[a] + time * (to_box[0] * m[0] + to_box[1] * m[1] + to_box[2] * m[2]);
    ray.direction[a] = to_box[0] * direction[0] + to_box[1] * direction[1] + to_box[2] * direction[2];
  }
  ray.metres_per_depth = std::sqrt(x * x + y * y + 1);
  return ray;
}

RaySample RaySampler::sample_at(const FieldRay& ray, float depth, float depth_step) const {
  return {point_at(ray, depth), depth, depth_step * ray.metres_per_depth * per_density_length_};
}

RaySampler::Draft RaySampler::draft_measured(const WarpedPixel& chosen) const {
  const StoredDepth stored = stored_pixel(chosen.pixel).depth;
  const float depth = stored.metres();
  const float reach = stored.is_measured() ? band_at(depth) : 2 * band_at(depth);
  Draft draft{chosen, {}, true};
  // A deforming layer's space before the surface is taught by rays of its own: here the ray may have bent.
  if (warped_foreground_.empty()) draft.strata[0] = {{sampling_.near_depth, depth - reach}, sampling_.free_samples};
  if (stored.is_guessed()) {
    draft.strata[1] = {{std::max(sampling_.near_depth, depth - reach), depth + reach}, sampling_.surface_samples};
  }
  return draft;
}

RaySampler::Draft RaySampler::draft(bool foreground, std::size_t index) const {
  if (!foreground) {
    const RaySegment& free = space_.free_space[index];
    return {{free.pixel, free.ray}, {{{free.segment, sampling_.free_space_ray_samples}}}, false};
  }
  if (index < measured_count()) return draft_measured(measured(index));
  const UnmeasuredRaySegment& unmeasured = space_.unmeasured[index - measured_count()];
  return {{unmeasured.pixel, unmeasured.ray, {}, unmeasured.rotation},
          {{{unmeasured.segment, sampling_.unmeasured_samples}}},
          true};
}

// One sample in each of so many equal parts of what lies in the box; those in empty space are left out. Occupied space
// is thin: a sample stands for no more of it than two cells. Then those in the band about a measured depth.
void RaySampler::append(std::span<const Draft> drafts, bool closely, Random& random, RayBatch& batch) const {
  RayPoints points;
  std::array<RayPoints::Column<float>, RayPoints::kMaxPoints> lengths; // of the pieces that the points stand for
  const auto two_cells = static_cast<float>(2 * config_.box.side / occupancy_.resolution());
  for (const Draft& draft : drafts) {
    const FieldRay& ray = draft.chosen.ray;
    const std::size_t r = points.rays;
    points.append(ray);
    std::size_t k = 0;
    for (const Draft::DepthStratum& stratum : draft.strata) {
      if (stratum.samples == 0) continue;
      const Interval inside = in_box(ray, stratum.depths);
      if (!(inside.begin < inside.end)) continue;
      const float step = (inside.end - inside.begin) / static_cast<float>(stratum.samples);
      for (int i = 0; i < stratum.samples; ++i, ++k) {
        points.depth[k][r] = inside.begin + step * (static_cast<float>(i) + random.uniform());
        lengths[k][r] = std::min(step, two_cells / ray.metres_per_depth);
      }
    }
    points.points[r] = static_cast<std::int32_t>(k);
  }
  occupied_->find(points);
  for (std::size_t r = 0; r < drafts.size(); ++r) {
    const Draft& draft = drafts[r];
    for (std::uint32_t bits = points.occupied[r]; bits != 0; bits &= bits - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(bits));
      batch.samples.push_back(sample_at(draft.chosen.ray, points.depth[k][r], lengths[k][r]));
    }
    RayTarget target;
    target.foreground = draft.foreground;
    if (draft.foreground) {
      const StoredPixel& pixel = stored_pixel(draft.chosen.pixel);
      for (std::size_t c = 0; c < 3; ++c) target.color[c] = static_cast<float>(pixel.color[c]) / 255.0F;
      target.rotation = unpacked(draft.chosen.rotation);
      if (pixel.depth.is_measured()) {
        append_band(draft.chosen, pixel.depth.metres(), closely, random, target, batch);
      }
    }
    batch.end_ray(target);
  }
}

void RaySampler::append_all(std::span<const Draft> drafts, bool closely, Random& random, RayBatch& batch) const {
  for (std::size_t begin = 0; begin < drafts.size(); begin += RayPoints::kMaxRays) {
    append(drafts.subspan(begin, std::min(RayPoints::kMaxRays, drafts.size() - begin)), closely, random, batch);
  }
}

void RaySampler::append_band(const WarpedPixel& chosen, float depth, bool closely, Random& random, RayTarget& target,
                             RayBatch& batch) const {
  const FieldRay& ray = chosen.ray;
  const float band = band_at(depth);
  target.depth = depth;
  target.inverse_band = 1.0F / band;
  target.lengths_per_depth = ray.metres_per_depth * per_density_length_;
  const float half = closely ? kCloseBand * band : band;
  const int count = closely ? kCloseSamples : sampling_.surface_samples;
  const float step = 2 * half / static_cast<float>(count);
  for (int i = 0; i < count; ++i) {
    const float at = depth - half + step * (static_cast<float>(i) + random.uniform());
    batch.samples.push_back(sample_at(ray, at, step));
    const float behind = at - depth;
    const std::array<float, 3>& curvature = chosen.curvatures[behind > 0 ? 1 : 0];
    for (std::size_t a = 0; a < 3; ++a) batch.samples.back().position[a] += behind * behind * curvature[a];
  }
}

WarpedPixel RaySampler::full_ray(const PixelRef& ref) const {
  return {ref.pixel, ray_of(ref), {}, frames_[ref.frame].rotation};
}

WarpedPixel RaySampler::measured(std::size_t index) const {
  return warped_foreground_.empty() ? full_ray(foreground_[index]) : warped_foreground_[index];
}

// What is read of a ray first.
const void* RaySampler::address_of(bool foreground, std::size_t index) const {
  if (!foreground) return &space_.free_space[index];
  if (index >= measured_count()) return &space_.unmeasured[index - measured_count()];
  return warped_foreground_.empty() ? static_cast<const void*>(&foreground_[index]) : &warped_foreground_[index];
}

// What a ray of a layer's own finds there of its pixel.
std::uint32_t RaySampler::pixel_of(std::size_t index) const {
  if (index >= measured_count()) return space_.unmeasured[index - measured_count()].pixel;
  return warped_foreground_.empty() ? foreground_[index].pixel : warped_foreground_[index].pixel;
}

void RaySampler::append_validation(std::size_t begin, std::size_t end, RayBatch& batch) const {
  Random random(0x7E57, begin);
  std::vector<Draft> drafts;
  for (std::size_t i = begin; i < end; ++i) drafts.push_back(draft_measured(validation_rays_[i]));
  append_all(drafts, false, random, batch);
}

void RaySampler::draw(Random& random, std::size_t chunk, std::size_t chunks, std::size_t count, float free_space_share,
                      bool closely, RayBatch& batch) const {
  const std::size_t free_count =
      space_.free_space.empty() ? 0 : static_cast<std::size_t>(static_cast<float>(count) * free_space_share);
  std::vector<std::size_t> indices;
  std::vector<Draft> drafts;
  for (const bool foreground : {false, true}) {
    const std::size_t here = foreground ? count - free_count : free_count;
    const std::size_t rays = foreground ? foreground_ray_count() : space_.free_space.size();
    indices.clear();
    const auto begin_of = [&](std::size_t part) { return rays * (chunk * here + part) / (here * chunks); };
    for (std::size_t i = 0, begin = 0, end = here > 0 ? begin_of(0) : 0; i < here; ++i) {
      begin = end;
      end = begin_of(i + 1);
      const std::size_t offset = end > begin ? random.below(static_cast<std::uint32_t>(end - begin)) : 0;
      indices.push_back(std::min(begin + offset, rays - 1));
      __builtin_prefetch(address_of(foreground, indices.back()));
    }
    if (foreground) {
      for (const std::size_t index : indices) __builtin_prefetch(&stored_pixel(pixel_of(index)));
    }
    drafts.clear();
    for (const std::size_t index : indices) drafts.push_back(draft(foreground, index));
    append_all(drafts, closely, random, batch);
  }
}

} // namespace kinora::fields
