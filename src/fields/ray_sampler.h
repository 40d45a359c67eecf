// From stored pixels to training rays: which pixels teach a layer what, and where samples lie along their rays.
#pragma once

#include <cstdint>
#include <vector>

#include "core/random.h"
#include "fields/field.h"
#include "fields/occupancy.h"
#include "fields/pixel_store.h"
#include "fields/ray_batch.h"
#include "fields/warped_pixels.h"
#include "tracking/motion.h"

namespace kinora::fields {

struct SamplingConfig {
  int surface_samples =
      5;                ///< stratified within the band around a measured depth; in occupied space near a doubtful one
  int free_samples = 4; ///< between the camera and the band; those in empty space are left out
  int unmeasured_samples =
      8; ///< where the ray first meets occupied space, for a pixel of the layer whose depth is not known
  int emptiness_samples = 4; ///< in occupied space before another layer's surface
  float near_depth = 0.05F;  ///< metres; nothing is modelled nearer to a camera
};

/// Rays of one layer. Pixels of the layer teach colour, opacity and depth; pixels of other layers teach emptiness
/// in front of their surface (surface_band.h, empty_until), and nothing behind. Immutable, so thread-safe.
class RaySampler {
public:
  /// `pixels` and `motion` must outlive the sampler.
  RaySampler(const PixelStore& pixels, int label, const tracking::Motion& motion, const FieldConfig& config,
             const SamplingConfig& sampling);

  /// Space around the measured surface of the layer: what a field starts from.
  Occupancy seed_occupancy() const;
  /// Samples are placed in this space from now on; finds the pixels of other layers that look through it.
  void set_occupancy(const Occupancy& occupancy);

  std::size_t own_ray_count() const {
    return own_.size() + unmeasured_.size() + warped_own_.size() + warped_space_.unmeasured.size();
  }
  std::size_t other_ray_count() const { return others_.size() + warped_space_.before.size(); }

  /// Appends the `count` rays of one of a step's `chunks` chunks, a quarter of them (if there are any) from other
  /// layers. Together the chunks take one random ray from each of count · chunks equal parts of the lists; each takes
  /// neighbouring parts.
  void draw(Random& random, std::size_t chunk, std::size_t chunks, std::size_t count, RayBatch& batch) const;

  /// Own rays that are never drawn, spread over the whole surface: what training is judged by.
  std::size_t held_apart_count() const { return held_apart_.size(); }
  /// Appends those of [begin, end), with the same samples each time.
  void judge(std::size_t begin, std::size_t end, RayBatch& batch) const;

private:
  struct FrameRays { // camera to box-relative coordinates
    std::array<float, 3> origin;
    std::array<float, 9> rotation; // row-major, divided by the box's side
    float fx, fy, cx, cy;
  };
  struct PixelRef {
    std::uint32_t frame; // into frames_
    std::uint32_t pixel;
  };
  struct PixelPiece { // what of a pixel's ray lies in occupied space
    PixelRef ref;
    Interval piece;
  };

  static constexpr int kBlockSide = 8; // pixels that are asked together whether they see anything
  static constexpr int kCoarse = 4;    // cells of occupancy along a side of a coarse one

  bool is_lost(const StoredFrame& frame) const;
  FrameRays frame_rays(const StoredFrame& frame) const;
  FieldRay ray_of(const PixelRef& ref) const;
  std::array<float, 3> place_of(const FieldRay& ray, std::uint32_t pixel) const;
  WarpedPixel whole_ray(const PixelRef& ref) const;
  WarpedPixel ray_at(bool own, std::size_t index) const;
  const void* ray_memory(bool own, std::size_t index) const;
  std::uint32_t pixel_at(bool own, std::size_t index) const;
  bool may_see(const DistanceField& distances, const FrameRays& frame, int u, int v) const;
  std::vector<bool> seeing_blocks(const DistanceField& distances, std::size_t frame) const;
  void find_pieces();
  void append_own(const WarpedPixel& chosen, Random& random, RayBatch& batch) const;
  void append_other(const WarpedPixel& chosen, Random& random, RayBatch& batch) const;
  void append_in_occupied(const FieldRay& ray, float near_depth, float far_depth, int count, Random& random,
                          RayBatch& batch) const;
  RaySample sample_at(const FieldRay& ray, float depth, float depth_step) const;
  bool is_occupied_in_box(const std::array<float, 3>& position) const;

  const PixelStore& pixels_;
  int label_;
  const tracking::Motion& motion_;
  FieldConfig config_;
  SamplingConfig sampling_;
  float per_density_length_; // 1 / metres
  // Of a layer that is still or rigid: rays are made when they are needed.
  std::vector<FrameRays> frames_;
  LargeBuffer<PixelRef> own_; // with depth
  std::vector<PixelPiece> unmeasured_;
  LargeBuffer<PixelPiece> others_;
  // Of a layer that deforms: rays are warped once and kept.
  LargeBuffer<WarpedPixel> warped_own_;
  WarpedSpace warped_space_;
  std::vector<WarpedPixel> held_apart_;
  Occupancy occupancy_;
  Occupancy coarse_occupancy_;
};

} // namespace kinora::fields
