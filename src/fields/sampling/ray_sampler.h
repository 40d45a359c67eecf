// From stored pixels to training rays: which pixels teach a layer what, and where samples lie along their rays.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/random.h"
#include "fields/model/field.h"
#include "fields/network/ray_batch.h"
#include "fields/sampling/layer_observations.h"
#include "fields/sampling/occupancy.h"
#include "fields/sampling/occupied_points.h"
#include "fields/sampling/space_observations.h"
#include "fields/sampling/surface_band.h"
#include "fields/sampling/warped_pixels.h"

namespace kinora::fields {

/// How many samples a ray has: at most RayPoints::kMaxPoints, those of surface and free space together.
struct SamplingConfig {
  int surface_samples =
      4;                ///< stratified within the band around a measured depth; in occupied space near a doubtful one
  int free_samples = 4; ///< between the camera and the band; those in empty space are left out
  int unmeasured_samples =
      8; ///< where the ray first meets occupied space, for a pixel of the layer whose depth is not known
  int free_space_ray_samples = 4; ///< in a piece of occupied space before a surface
  float near_depth = 0.05F;       ///< metres; nothing is modelled nearer to a camera
};

/// Rays of one layer. Pixels of the layer teach colour, opacity and depth; pixels of other layers teach emptiness
/// in front of their surface (space_observations.h), and nothing behind. Immutable, so thread-safe.
class RaySampler {
public:
  /// What `layer` is a view of must outlive the sampler. `noise`: LossWeights::noise. Throws Error(kUsage) for too many
  /// samples.
  RaySampler(const LayerObservations& layer, const FieldConfig& config, const SamplingConfig& sampling,
             SensorNoise noise = {});

  /// Space around the measured surface of the layer: what a field starts from, and where samples lie.
  const Occupancy& occupancy() const { return occupancy_; }

  std::size_t foreground_ray_count() const { return measured_count() + space_.unmeasured.size(); }

  /// Appends the `count` rays of one of a step's `chunks` chunks, a share of them (if there are any) from space that is
  /// seen to be empty. Together the chunks take one random ray from each of count · chunks equal parts of the lists;
  /// each takes neighbouring parts. `closely`: fewer samples, in a narrower band about measured depths.
  void draw(Random& random, std::size_t chunk, std::size_t chunks, std::size_t count, float free_space_share,
            bool closely, RayBatch& batch) const;

  /// Own rays that are never drawn, spread over the whole surface: what training is judged by.
  std::size_t validation_ray_count() const { return validation_rays_.size(); }
  /// Appends those of [begin, end), with the same samples each time.
  void append_validation(std::size_t begin, std::size_t end, RayBatch& batch) const;

private:
  struct FrameRays { // camera to box-relative coordinates
    std::array<float, 3> origin;
    std::array<float, 9> camera_to_box; // row-major, divided by the box's side
    float per_fx, per_fy, cx, cy, per_height;
    std::array<float, 6> readout; // StoredFrame::readout
    PackedRotation rotation;
  };
  struct PixelRef {
    std::uint32_t frame; // into frames_
    std::uint32_t pixel;
  };

  struct Draft { // a ray to be drawn
    struct DepthStratum {
      Interval depths;
      int samples = 0;
    };
    WarpedPixel chosen;
    std::array<DepthStratum, 2> strata; // samples in occupied space, besides those about a measured depth
    bool foreground;
  };

  FrameRays frame_rays(const StoredFrame& frame) const;
  FieldRay ray_of(const PixelRef& ref) const;
  void list_foreground();
  template <class Rays, class FullRay> void arrange(Rays& rays, const FullRay& full_ray_of);
  void mark(const WarpedPixel& foreground);
  WarpedPixel full_ray(const PixelRef& ref) const;
  std::size_t measured_count() const { return foreground_.size() + warped_foreground_.size(); }
  WarpedPixel measured(std::size_t index) const;
  const StoredPixel& stored_pixel(std::uint32_t index) const { return layer_.pixels.pixels()[index]; }
  const void* address_of(bool foreground, std::size_t index) const;
  std::uint32_t pixel_of(std::size_t index) const;
  Draft draft(bool foreground, std::size_t index) const;
  Draft draft_measured(const WarpedPixel& chosen) const;
  void append_all(std::span<const Draft> drafts, bool closely, Random& random, RayBatch& batch) const;
  void append(std::span<const Draft> drafts, bool closely, Random& random, RayBatch& batch) const;
  void append_band(const WarpedPixel& chosen, float depth, bool closely, Random& random, RayTarget& target,
                   RayBatch& batch) const;
  RaySample sample_at(const FieldRay& ray, float depth, float depth_step) const;
  float band_at(float depth) const { return std::max(noise_.three_sigma(depth), min_band_); } // surface_band()

  LayerObservations layer_;
  FieldConfig config_;
  SamplingConfig sampling_;
  SensorNoise noise_;
  float per_density_length_; // 1 / metres
  float min_band_;
  // Own pixels with depth, in the order of the places that they show. Of a layer that is still or rigid, rays are made
  // when they are needed; of one that deforms they are warped once and kept.
  std::vector<FrameRays> frames_;
  LargeBuffer<PixelRef> foreground_;
  LargeBuffer<WarpedPixel> warped_foreground_;
  SpaceObservations space_;
  std::vector<WarpedPixel> validation_rays_;
  Occupancy occupancy_;
  std::optional<OccupiedPoints> occupied_; // once all is marked
};

} // namespace kinora::fields
