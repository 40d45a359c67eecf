#include "fields/ray_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "fields/surface_band.h"

namespace kinora::fields {
RaySampler::RaySampler(const PixelStore& pixels, int label, const tracking::Motion& motion, const FieldConfig& config,
                       const SamplingConfig& sampling)
    : pixels_(pixels), label_(label), motion_(motion), config_(config), sampling_(sampling) {
  if (motion.kind() == tracking::MotionKind::kDeforming) {
    warped_own_ = warp_measured_pixels(pixels, label, motion, config);
    return;
  }
  for (const StoredFrame& stored : pixels.frames()) frames_.push_back(frame_rays(stored));
  for (std::uint32_t f = 0; f < pixels.frames().size(); ++f) {
    const StoredFrame& stored = pixels.frames()[f];
    if (motion.health(static_cast<std::size_t>(stored.frame)) == tracking::Health::kLost) continue;
    for (std::size_t i = stored.begin; i < stored.end; ++i) {
      const StoredPixel& pixel = pixels.pixels()[i];
      // A mask says that a pixel is the layer's even where no depth is known; for the background nothing does.
      if (pixel.label == label && (label != 0 || pixel.depth != 0)) own_.push_back({f, static_cast<std::uint32_t>(i)});
    }
  }
}

RaySampler::FrameRays RaySampler::frame_rays(const StoredFrame& frame) const {
  const SE3 canonical_from_camera = motion_.canonical_to_world(frame.frame).inverse() * frame.camera.camera_to_world;
  const Intrinsics& k = frame.camera.intrinsics;
  FrameRays rays{};
  Eigen::Map<Eigen::Vector3f>(rays.origin.data()) =
      ((canonical_from_camera.translation() - config_.box.origin) / config_.box.side).cast<float>();
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(rays.rotation.data()) =
      (canonical_from_camera.linear() / config_.box.side).cast<float>();
  rays.fx = static_cast<float>(k.fx);
  rays.fy = static_cast<float>(k.fy);
  rays.cx = static_cast<float>(k.cx);
  rays.cy = static_cast<float>(k.cy);
  return rays;
}

FieldRay RaySampler::ray_of(const PixelRef& ref) const {
  const FrameRays& frame = frames_[ref.frame];
  const StoredPixel& pixel = pixels_.pixels()[ref.pixel];
  const float x = (static_cast<float>(pixel.u) - frame.cx) / frame.fx;
  const float y = (static_cast<float>(pixel.v) - frame.cy) / frame.fy;
  FieldRay ray{};
  ray.origin = frame.origin;
  for (std::size_t a = 0; a < 3; ++a) {
    ray.direction[a] = frame.rotation[3 * a] * x + frame.rotation[3 * a + 1] * y + frame.rotation[3 * a + 2];
  }
  ray.metres_per_depth = std::sqrt(x * x + y * y + 1);
  return ray;
}

Occupancy RaySampler::seed_occupancy() const {
  Occupancy occupancy(config_.occupancy_resolution);
  const auto mark = [&](std::size_t pixel, const FieldRay& ray) {
    const float depth = std::abs(pixels_.pixels()[pixel].depth);
    if (depth == 0) return;
    const float band = surface_band(config_, depth);
    mark_occupied(occupancy, ray, {depth - band, depth + band});
  };
  constexpr std::size_t kChunk = 16384;
  parallel_for(own_.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) mark(own_[i].pixel, ray_of(own_[i]));
  });
  parallel_for(warped_own_.size(), kChunk, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) mark(warped_own_[i].pixel, warped_own_[i].ray);
  });
  return occupancy;
}

void RaySampler::set_occupancy(const Occupancy& occupancy) {
  distances_ = DistanceField(occupancy);
  if (motion_.kind() == tracking::MotionKind::kDeforming) {
    warped_space_ = warp_occupied_space(pixels_, label_, motion_, config_, occupancy, sampling_.near_depth);
  } else {
    find_others();
  }
}

// The pixels of other layers that look through occupied space.
void RaySampler::find_others() {
  constexpr std::size_t kChunk = 16384;
  const std::vector<StoredPixel>& all = pixels_.pixels();
  std::vector<std::vector<PixelRef>> found(chunk_count(all.size(), kChunk));
  parallel_for(all.size(), kChunk, [&](const Chunk& chunk) {
    const auto& frames = pixels_.frames();
    auto f = static_cast<std::uint32_t>(
        std::upper_bound(frames.begin(), frames.end(), chunk.begin,
                         [](std::size_t at, const StoredFrame& frame) { return at < frame.end; }) -
        frames.begin());
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      while (i >= frames[f].end) ++f;
      if (all[i].label == label_) continue;
      const PixelRef ref{f, static_cast<std::uint32_t>(i)};
      OccupiedIntervals walk(distances_, ray_of(ref), sampling_.near_depth, empty_until(all[i]));
      Interval interval{};
      if (walk.next(interval)) found[chunk.index].push_back(ref);
    }
  });
  others_.clear();
  for (const auto& part : found) others_.insert(others_.end(), part.begin(), part.end());
}

void RaySampler::append_sample(const FieldRay& ray, float depth, float depth_step, RayBatch& batch) const {
  RaySample sample{};
  for (std::size_t a = 0; a < 3; ++a) sample.position[a] = ray.origin[a] + depth * ray.direction[a];
  sample.depth = depth;
  sample.length = depth_step * ray.metres_per_depth / static_cast<float>(config_.density_length());
  batch.samples.push_back(sample);
}

void RaySampler::append_in_occupied(const FieldRay& ray, float near_depth, float far_depth, int count, Random& random,
                                    RayBatch& batch) const {
  constexpr std::size_t kMaxIntervals = 12;
  std::array<Interval, kMaxIntervals> intervals{};
  std::size_t found = 0;
  float total = 0;
  OccupiedIntervals walk(distances_, ray, near_depth, far_depth);
  while (found < kMaxIntervals && walk.next(intervals[found])) {
    total += intervals[found].end - intervals[found].begin;
    ++found;
  }
  if (found == 0 || !(total > 0)) return;
  const float step = total / static_cast<float>(count);
  std::size_t current = 0;
  float before = 0; // length of the intervals before the current one
  for (int i = 0; i < count; ++i) {
    const float along = (static_cast<float>(i) + random.uniform()) * step;
    while (current + 1 < found && along - before > intervals[current].end - intervals[current].begin) {
      before += intervals[current].end - intervals[current].begin;
      ++current;
    }
    append_sample(ray, intervals[current].begin + along - before, step, batch);
  }
}

void RaySampler::append_own(const WarpedPixel& chosen, Random& random, RayBatch& batch) const {
  const StoredPixel& pixel = pixels_.pixels()[chosen.pixel];
  const FieldRay& ray = chosen.ray;
  RayTarget target;
  for (std::size_t c = 0; c < 3; ++c) target.color[c] = static_cast<float>(pixel.color[c]) / 255.0F;
  const float depth = std::abs(pixel.depth);
  const float band = surface_band(config_, depth);
  if (pixel.depth > 0) {
    target.depth = depth;
    target.inverse_band = 1.0F / band;
    // A deforming layer's space before the surface is taught by rays of its own: here the ray may have bent.
    if (warped_own_.empty()) {
      append_in_occupied(ray, sampling_.near_depth, depth - band, sampling_.free_samples, random, batch);
    }
    const float step = 2 * band / static_cast<float>(sampling_.surface_samples);
    for (int i = 0; i < sampling_.surface_samples; ++i) {
      append_sample(ray, depth - band + step * (static_cast<float>(i) + random.uniform()), step, batch);
    }
  } else if (pixel.depth < 0) {
    append_in_occupied(ray, std::max(sampling_.near_depth, depth - 2 * band), depth + 2 * band,
                       sampling_.surface_samples, random, batch);
  } else {
    append_in_occupied(ray, chosen.piece.begin, chosen.piece.end, sampling_.unmeasured_samples, random, batch);
  }
  batch.targets.push_back(target);
  batch.first_sample.push_back(static_cast<std::uint32_t>(batch.samples.size()));
}

void RaySampler::append_other(const WarpedPixel& chosen, Random& random, RayBatch& batch) const {
  RayTarget target;
  target.own = false;
  append_in_occupied(chosen.ray, chosen.piece.begin, chosen.piece.end, sampling_.emptiness_samples, random, batch);
  batch.targets.push_back(target);
  batch.first_sample.push_back(static_cast<std::uint32_t>(batch.samples.size()));
}

WarpedPixel RaySampler::chosen(bool own, Random& random) const {
  const auto any = [&random](const auto& list) { return list[random.below(static_cast<std::uint32_t>(list.size()))]; };
  if (!warped_own_.empty()) {
    if (!own) return any(warped_space_.before);
    const std::size_t i = random.below(static_cast<std::uint32_t>(own_ray_count()));
    return i < warped_own_.size() ? warped_own_[i] : warped_space_.unmeasured[i - warped_own_.size()];
  }
  const PixelRef ref = any(own ? own_ : others_);
  const float end = own ? kFarthest : empty_until(pixels_.pixels()[ref.pixel]);
  return {ref.pixel, ray_of(ref), {sampling_.near_depth, end}};
}

void RaySampler::draw(Random& random, std::size_t count, RayBatch& batch) const {
  const std::size_t from_others = other_ray_count() == 0 ? 0 : count / 4;
  for (std::size_t i = 0; i < count; ++i) {
    const bool own = i >= from_others;
    const WarpedPixel ray = chosen(own, random);
    if (own) {
      append_own(ray, random, batch);
    } else {
      append_other(ray, random, batch);
    }
  }
}

} // namespace kinora::fields
