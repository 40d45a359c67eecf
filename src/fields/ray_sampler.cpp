#include "fields/ray_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "ingest/sensor_noise.h"

namespace kinora::fields {
namespace {

constexpr float kFarthest = 1e6F; // metres

float three_sigma(float depth) { return static_cast<float>(3.0 * ingest::depth_sigma(depth)); }

} // namespace

float surface_band(const FieldConfig& config, float depth) {
  const double pose_error = std::min(0.02, 0.02 * config.box.side);
  return std::max({three_sigma(depth), static_cast<float>(4 * config.cell_size()), static_cast<float>(pose_error)});
}

RaySampler::RaySampler(const PixelStore& pixels, int label, const tracking::Motion& motion, const FieldConfig& config,
                       const SamplingConfig& sampling)
    : pixels_(pixels), label_(label), config_(config), sampling_(sampling) {
  for (const StoredFrame& stored : pixels.frames()) {
    const SE3 canonical_from_camera = motion.canonical_to_world(stored.frame).inverse() * stored.camera.camera_to_world;
    const Eigen::Vector3f origin =
        ((canonical_from_camera.translation() - config.box.origin) / config.box.side).cast<float>();
    const Eigen::Matrix3f rotation = (canonical_from_camera.linear() / config.box.side).cast<float>();
    const Intrinsics& k = stored.camera.intrinsics;
    FrameRays rays{};
    Eigen::Map<Eigen::Vector3f>(rays.origin.data()) = origin;
    Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(rays.rotation.data()) = rotation;
    rays.fx = static_cast<float>(k.fx);
    rays.fy = static_cast<float>(k.fy);
    rays.cx = static_cast<float>(k.cx);
    rays.cy = static_cast<float>(k.cy);
    frames_.push_back(rays);
  }
  for (std::uint32_t f = 0; f < pixels.frames().size(); ++f) {
    const StoredFrame& stored = pixels.frames()[f];
    if (motion.health(static_cast<std::size_t>(stored.frame)) == tracking::Health::kLost) continue;
    for (std::size_t i = stored.begin; i < stored.end; ++i) {
      const StoredPixel& pixel = pixels.pixels()[i];
      // A mask says that a pixel is the layer's even where no depth was measured; for the background nothing does.
      if (pixel.label == label && (label != 0 || pixel.depth != 0)) own_.push_back({f, static_cast<std::uint32_t>(i)});
    }
  }
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
  parallel_for(own_.size(), 16384, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const float depth = pixels_.pixels()[own_[i].pixel].depth;
      if (depth <= 0) continue;
      const float band = surface_band(config_, depth);
      mark_occupied(occupancy, ray_of(own_[i]), {depth - band, depth + band});
    }
  });
  return occupancy;
}

void RaySampler::set_occupancy(const Occupancy& occupancy) {
  distances_ = DistanceField(occupancy);
  constexpr std::size_t kChunk = 16384;
  const std::vector<StoredPixel>& all = pixels_.pixels();
  std::vector<std::vector<PixelRef>> found(chunk_count(all.size(), kChunk));
  parallel_for(all.size(), kChunk, [&](const Chunk& chunk) {
    const auto& frames = pixels_.frames();
    std::uint32_t f = static_cast<std::uint32_t>(
        std::upper_bound(frames.begin(), frames.end(), chunk.begin,
                         [](std::size_t at, const StoredFrame& frame) { return at < frame.end; }) -
        frames.begin());
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      while (i >= frames[f].end) ++f;
      if (all[i].label == label_ || all[i].depth <= 0) continue;
      const PixelRef ref{f, static_cast<std::uint32_t>(i)};
      OccupiedIntervals walk(distances_, ray_of(ref), sampling_.near_depth, all[i].depth - three_sigma(all[i].depth));
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

void RaySampler::append_own(const PixelRef& ref, Random& random, RayBatch& batch) const {
  const StoredPixel& pixel = pixels_.pixels()[ref.pixel];
  const FieldRay ray = ray_of(ref);
  RayTarget target;
  for (std::size_t c = 0; c < 3; ++c) target.color[c] = static_cast<float>(pixel.color[c]) / 255.0F;
  if (pixel.depth > 0) {
    const float band = surface_band(config_, pixel.depth);
    target.depth = pixel.depth;
    target.inverse_band = 1.0F / band;
    append_in_occupied(ray, sampling_.near_depth, pixel.depth - band, sampling_.free_samples, random, batch);
    const float step = 2 * band / static_cast<float>(sampling_.surface_samples);
    for (int i = 0; i < sampling_.surface_samples; ++i) {
      append_sample(ray, pixel.depth - band + step * (static_cast<float>(i) + random.uniform()), step, batch);
    }
  } else if (pixel.depth < 0) {
    const float depth = -pixel.depth;
    const float reach = 2 * surface_band(config_, depth);
    append_in_occupied(ray, std::max(sampling_.near_depth, depth - reach), depth + reach, sampling_.surface_samples,
                       random, batch);
  } else {
    append_in_occupied(ray, sampling_.near_depth, kFarthest, sampling_.unmeasured_samples, random, batch);
  }
  batch.targets.push_back(target);
  batch.first_sample.push_back(static_cast<std::uint32_t>(batch.samples.size()));
}

void RaySampler::append_other(const PixelRef& ref, Random& random, RayBatch& batch) const {
  const StoredPixel& pixel = pixels_.pixels()[ref.pixel];
  RayTarget target;
  target.own = false;
  append_in_occupied(ray_of(ref), sampling_.near_depth, pixel.depth - three_sigma(pixel.depth),
                     sampling_.emptiness_samples, random, batch);
  batch.targets.push_back(target);
  batch.first_sample.push_back(static_cast<std::uint32_t>(batch.samples.size()));
}

void RaySampler::draw(Random& random, std::size_t count, RayBatch& batch) const {
  const std::size_t from_others = others_.empty() ? 0 : (own_.empty() ? count : count / 4);
  constexpr std::size_t kGroup = 32; // pixels looked up together, so that their cache misses overlap
  std::array<PixelRef, kGroup> refs{};
  for (std::size_t begin = 0; begin < count; begin += kGroup) {
    const std::size_t size = std::min(kGroup, count - begin);
    for (std::size_t i = 0; i < size; ++i) {
      const std::vector<PixelRef>& source = begin + i < from_others ? others_ : own_;
      refs[i] = source[random.below(static_cast<std::uint32_t>(source.size()))];
      __builtin_prefetch(&pixels_.pixels()[refs[i].pixel]);
    }
    for (std::size_t i = 0; i < size; ++i) {
      if (begin + i < from_others) {
        append_other(refs[i], random, batch);
      } else {
        append_own(refs[i], random, batch);
      }
    }
  }
}

} // namespace kinora::fields
