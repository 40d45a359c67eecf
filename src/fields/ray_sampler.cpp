#include "fields/ray_sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "fields/ray_order.h"
#include "fields/surface_band.h"

namespace kinora::fields {
namespace {

// Takes every so many-th of a list, at most about four thousand, and leaves the others in order.
template <class Rays, class Take> void take_some(Rays& rays, const Take& take) {
  constexpr std::size_t kMost = 4096;
  constexpr std::size_t kLeastStride = 32;
  const std::size_t stride = std::max(kLeastStride, rays.size() / kMost);
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

RaySampler::RaySampler(const PixelStore& pixels, int label, const tracking::Motion& motion, const FieldConfig& config,
                       const SamplingConfig& sampling)
    : pixels_(pixels), label_(label), motion_(motion), config_(config), sampling_(sampling),
      per_density_length_(static_cast<float>(1 / config.density_length())) {
  if (motion.kind() == tracking::MotionKind::kDeforming) {
    warped_own_ = warp_measured_pixels(pixels, label, motion, config);
    order_by_place(warped_own_, [&](const WarpedPixel& own) { return place_of(own.ray, own.pixel); });
    take_some(warped_own_, [&](const WarpedPixel& own) { held_apart_.push_back(own); });
    return;
  }
  for (const StoredFrame& stored : pixels.frames()) frames_.push_back(frame_rays(stored));
  for (std::uint32_t f = 0; f < pixels.frames().size(); ++f) {
    const StoredFrame& stored = pixels.frames()[f];
    if (is_lost(stored)) continue;
    for (std::size_t i = stored.begin; i < stored.end; ++i) {
      const StoredPixel& pixel = pixels.pixels()[i];
      if (pixel.label == label && pixel.depth != 0) own_.push_back({f, static_cast<std::uint32_t>(i)});
    }
  }
  order_by_place(own_, [&](const PixelRef& ref) { return place_of(ray_of(ref), ref.pixel); });
  take_some(own_, [&](const PixelRef& ref) { held_apart_.push_back(whole_ray(ref)); });
}

// Nothing is known of where the layer was then.
bool RaySampler::is_lost(const StoredFrame& frame) const {
  return motion_.health(static_cast<std::size_t>(frame.frame)) == tracking::Health::kLost;
}

// Where the ray meets the layer's surface.
std::array<float, 3> RaySampler::place_of(const FieldRay& ray, std::uint32_t pixel) const {
  return point_at(ray, std::abs(pixels_.pixels()[pixel].depth));
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
  occupancy_ = occupancy;
  coarse_occupancy_ = coarsened(occupancy, kCoarse);
  if (motion_.kind() == tracking::MotionKind::kDeforming) {
    warped_space_ = warp_occupied_space(pixels_, label_, motion_, config_, occupancy, sampling_.near_depth);
  } else {
    find_pieces();
  }
}

// Whether anything occupied may lie between the rays of a block of kBlockSide² pixels: the middle ray is followed in
// steps so long that what is known to be empty around it holds the whole block.
bool RaySampler::may_see(const DistanceField& distances, const FrameRays& frame, int u, int v) const {
  constexpr float kHalf = 0.5F * (kBlockSide - 1);
  const auto cells = static_cast<float>(distances.resolution());
  const float x = (static_cast<float>(u) + kHalf - frame.cx) / frame.fx;
  const float y = (static_cast<float>(v) + kHalf - frame.cy) / frame.fy;
  std::array<float, 3> origin{};    // cells
  std::array<float, 3> direction{}; // cells per metre of depth
  float speed = 0;                  // its largest part
  float spread = 0;                 // the same of what the block's outermost rays differ by
  float end = 0;                    // metres: depth of the box's farthest corner
  const float side = static_cast<float>(config_.box.side);
  for (std::size_t a = 0; a < 3; ++a) {
    const float* row = &frame.rotation[3 * a];
    origin[a] = frame.origin[a] * cells;
    direction[a] = (row[0] * x + row[1] * y + row[2]) * cells;
    speed = std::max(speed, std::abs(direction[a]));
    spread = std::max(spread, (std::abs(row[0] / frame.fx) + std::abs(row[1] / frame.fy)) * kHalf * cells);
    end += side * side * row[2] * ((row[2] > 0 ? 1.0F : 0.0F) - frame.origin[a]);
  }
  float depth = sampling_.near_depth;
  while (depth < end) {
    std::array<int, 3> cell{}; // outside the box the nearest inside, which is no farther from anything occupied
    float outside = 0;         // cells
    for (std::size_t a = 0; a < 3; ++a) {
      const float at = origin[a] + depth * direction[a];
      cell[a] = static_cast<int>(std::clamp(at, 0.0F, cells - 1));
      outside = std::max({outside, -at, at - cells});
    }
    const float empty = std::max(static_cast<float>(distances.at(cell[0], cell[1], cell[2]) - 1), outside);
    const float step = (empty - spread * depth) / (speed + spread);
    if (!(step * speed > 0.5F)) return true;
    depth += step;
  }
  return false;
}

// The blocks of a frame's image whose pixels may see occupied space, row by row.
std::vector<bool> RaySampler::seeing_blocks(const DistanceField& distances, std::size_t frame) const {
  const Intrinsics& k = pixels_.frames()[frame].camera.intrinsics;
  std::vector<bool> seeing;
  for (int v = 0; v < k.height; v += kBlockSide) {
    for (int u = 0; u < k.width; u += kBlockSide) seeing.push_back(may_see(distances, frames_[frame], u, v));
  }
  return seeing;
}

// What pixels of other layers see of occupied space, and where own pixels without depth first meet it. A mask says that
// a pixel is the layer's even where no depth is known; for the background nothing does.
void RaySampler::find_pieces() {
  constexpr std::size_t kChunk = 16384;
  struct Found {
    std::vector<PixelPiece> unmeasured, others;
  };
  const DistanceField distances(occupancy_);
  const auto& frames = pixels_.frames();
  std::vector<std::vector<bool>> seeing(frames.size());
  parallel_for(frames.size(), 1, [&](const Chunk& chunk) {
    if (!is_lost(frames[chunk.index])) seeing[chunk.index] = seeing_blocks(distances, chunk.index);
  });
  const auto may_see_any = [&](std::size_t f, const StoredPixel& pixel) {
    const auto across = static_cast<std::size_t>((frames[f].camera.intrinsics.width + kBlockSide - 1) / kBlockSide);
    return seeing[f][pixel.v / kBlockSide * across + pixel.u / kBlockSide];
  };
  const LargeBuffer<StoredPixel>& all = pixels_.pixels();
  std::vector<Found> found(chunk_count(all.size(), kChunk));
  parallel_for(all.size(), kChunk, [&](const Chunk& chunk) {
    auto f = static_cast<std::uint32_t>(
        std::upper_bound(frames.begin(), frames.end(), chunk.begin,
                         [](std::size_t at, const StoredFrame& frame) { return at < frame.end; }) -
        frames.begin());
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      while (i >= frames[f].end) ++f;
      const bool own = all[i].label == label_;
      if (is_lost(frames[f]) || (own && (label_ == 0 || all[i].depth != 0)) || !may_see_any(f, all[i])) continue;
      PixelPiece piece{{f, static_cast<std::uint32_t>(i)}, {}};
      OccupiedIntervals walk(distances, ray_of(piece.ref), sampling_.near_depth, own ? kFarthest : empty_until(all[i]));
      if (own) {
        if (walk.next(piece.piece)) found[chunk.index].unmeasured.push_back(piece);
      } else {
        while (walk.next(piece.piece)) found[chunk.index].others.push_back(piece);
      }
    }
  });
  unmeasured_.clear();
  others_.clear();
  for (const Found& part : found) {
    unmeasured_.insert(unmeasured_.end(), part.unmeasured.begin(), part.unmeasured.end());
    others_.insert(others_.end(), part.others.begin(), part.others.end());
  }
}

RaySample RaySampler::sample_at(const FieldRay& ray, float depth, float depth_step) const {
  return {point_at(ray, depth), depth, depth_step * ray.metres_per_depth * per_density_length_};
}

// Most of what is asked for is empty, which the coarse cells tell from the nearest cache.
bool RaySampler::is_occupied_in_box(const std::array<float, 3>& position) const {
  const int last = occupancy_.resolution() - 1;
  const auto cell = [&](float x) { return std::clamp(static_cast<int>(x * static_cast<float>(last + 1)), 0, last); };
  const int x = cell(position[0]);
  const int y = cell(position[1]);
  const int z = cell(position[2]);
  return coarse_occupancy_.at(x / kCoarse, y / kCoarse, z / kCoarse) && occupancy_.at(x, y, z);
}

// One sample in each of `count` equal parts of what lies in the box; those in empty space are left out. Occupied space
// is thin: a sample stands for no more of it than two cells.
void RaySampler::append_in_occupied(const FieldRay& ray, float near_depth, float far_depth, int count, Random& random,
                                    RayBatch& batch) const {
  const Interval inside = in_box(ray, {near_depth, far_depth});
  if (!(inside.begin < inside.end)) return;
  const float step = (inside.end - inside.begin) / static_cast<float>(count);
  const auto cell = static_cast<float>(config_.box.side / occupancy_.resolution());
  const float length = std::min(step, 2 * cell / ray.metres_per_depth);
  // Which ones are left out is anybody's guess: so each is written, and the next one over it if it does not count.
  std::size_t end = batch.samples.size();
  batch.samples.resize(end + static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const float depth = inside.begin + step * (static_cast<float>(i) + random.uniform());
    const RaySample sample = sample_at(ray, depth, length);
    batch.samples[end] = sample;
    end += is_occupied_in_box(sample.position) ? 1 : 0;
  }
  batch.samples.resize(end);
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
    target.lengths_per_depth = ray.metres_per_depth * per_density_length_;
    // A deforming layer's space before the surface is taught by rays of its own: here the ray may have bent.
    if (warped_own_.empty()) {
      append_in_occupied(ray, sampling_.near_depth, depth - band, sampling_.free_samples, random, batch);
    }
    const float step = 2 * band / static_cast<float>(sampling_.surface_samples);
    for (int i = 0; i < sampling_.surface_samples; ++i) {
      const float at = depth - band + step * (static_cast<float>(i) + random.uniform());
      batch.samples.push_back(sample_at(ray, at, step));
      const float behind = at - depth;
      const std::array<float, 3>& bend = chosen.bends[behind > 0 ? 1 : 0];
      for (std::size_t a = 0; a < 3; ++a) batch.samples.back().position[a] += behind * behind * bend[a];
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

WarpedPixel RaySampler::whole_ray(const PixelRef& ref) const {
  return {ref.pixel, ray_of(ref), {sampling_.near_depth, kFarthest}, {}};
}

WarpedPixel RaySampler::ray_at(bool own, std::size_t index) const {
  if (motion_.kind() == tracking::MotionKind::kDeforming) {
    if (!own) return warped_space_.before[index];
    return index < warped_own_.size() ? warped_own_[index] : warped_space_.unmeasured[index - warped_own_.size()];
  }
  if (own && index < own_.size()) return whole_ray(own_[index]);
  const PixelPiece& piece = own ? unmeasured_[index - own_.size()] : others_[index];
  return {piece.ref.pixel, ray_of(piece.ref), piece.piece, {}};
}

// The memory that ray_at() reads first, and what it finds there of the pixel.
const void* RaySampler::ray_memory(bool own, std::size_t index) const {
  if (motion_.kind() == tracking::MotionKind::kDeforming) {
    if (!own) return &warped_space_.before[index];
    return index < warped_own_.size() ? &warped_own_[index] : &warped_space_.unmeasured[index - warped_own_.size()];
  }
  if (own && index < own_.size()) return &own_[index];
  return own ? &unmeasured_[index - own_.size()] : &others_[index];
}

std::uint32_t RaySampler::pixel_at(bool own, std::size_t index) const {
  if (motion_.kind() == tracking::MotionKind::kDeforming) return ray_at(own, index).pixel;
  if (own && index < own_.size()) return own_[index].pixel;
  return (own ? unmeasured_[index - own_.size()] : others_[index]).ref.pixel;
}

void RaySampler::judge(std::size_t begin, std::size_t end, RayBatch& batch) const {
  Random random(0x7E57, begin);
  for (std::size_t i = begin; i < end; ++i) append_own(held_apart_[i], random, batch);
}

void RaySampler::draw(Random& random, std::size_t chunk, std::size_t chunks, std::size_t count, RayBatch& batch) const {
  const std::size_t from_others = other_ray_count() == 0 ? 0 : count / 4;
  std::vector<std::size_t> indices;
  for (const bool own : {false, true}) {
    const std::size_t here = own ? count - from_others : from_others;
    const std::size_t rays = own ? own_ray_count() : other_ray_count();
    indices.clear();
    const auto begin_of = [&](std::size_t part) { return rays * (chunk * here + part) / (here * chunks); };
    for (std::size_t i = 0, begin = 0, end = here > 0 ? begin_of(0) : 0; i < here; ++i) {
      begin = end;
      end = begin_of(i + 1);
      const std::size_t spread = end > begin ? random.below(static_cast<std::uint32_t>(end - begin)) : 0;
      indices.push_back(std::min(begin + spread, rays - 1));
      __builtin_prefetch(ray_memory(own, indices.back()));
    }
    for (const std::size_t index : indices) __builtin_prefetch(&pixels_.pixels()[pixel_at(own, index)]);
    for (const std::size_t index : indices) {
      if (own) {
        append_own(ray_at(own, index), random, batch);
      } else {
        append_other(ray_at(own, index), random, batch);
      }
    }
  }
}

} // namespace kinora::fields
