// From where rays enter a layer to the surfaces that they meet in it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fields/rendering/projected_layer.h"
#include "fields/rendering/rasterizer.h"
#include "fields/rendering/ray_marching.h"
#include "fields/rendering/smooth_cells.h"
#include "fields/rendering/surface.h"

namespace kinora::fields {

/// Share of a pixel's light below which a surface is not looked at.
inline constexpr float kMinShare = 0.004F;

/// A pixel's ray in the camera's frame.
struct PixelRay {
  Eigen::Vector3f view_vector; ///< (x, y, 1)
  float inverse_length;
};
using PixelRays = std::array<PixelRay, Entries::kPixels>;
using Surfaces = PixelLists<Surface, 8>;

/// Of the light behind a pixel's surfaces up to a depth, front to back; nothing after kOpaque is looked at.
inline float transmittance_before(const Surfaces& surfaces, std::size_t pixel, float depth) {
  float transmittance = 1;
  for (std::size_t i = 0; i < surfaces.count(pixel) && transmittance > kOpaque; ++i) {
    const Surface& surface = surfaces.at(pixel, i);
    if (!(surface.depth < depth)) break;
    transmittance -= transmittance * surface.opacity;
  }
  return transmittance;
}

/// Finds the surfaces of one layer in a tile.
class TileMarcher {
public:
  /// What it is made from must outlive it.
  TileMarcher(const ProjectedLayer& view, std::uint32_t layer, const TriangleBins& bins)
      : view_(&view), bins_(&bins), layer_(layer) {}

  /// To be filled before anything is marched.
  Entries& entries() { return entries_; }
  void begin_tile() { anchored_ = false; }
  /// Adds the surfaces of those pixels, and before the first of a tile those at all anchors of SmoothCells. With
  /// `only_visible` none need be added where rays enter this layer behind surfaces that are opaque together.
  void march(const PixelRays& pixel_rays, std::span<const std::uint32_t> pixels, bool only_visible, Surfaces& surfaces);

private:
  struct Ray {
    std::uint32_t pixel;
    std::size_t next;     // entry
    bool is_unobstructed; // has met nothing yet
    bool has_just_entered;
    float entry_depth;
    float depth_step;
    Eigen::Vector3f origin, direction;
    Rotation rotation;
  };
  // Stands the ray at its next entry that is not one of where it comes from; false if there is none.
  bool enter(const PixelRay& pixel_ray, float until_depth, Ray& ray, float& begin) const;

  void march_anchors(const PixelRays& pixel_rays, Surfaces& surfaces);
  bool enters_behind(const Surfaces& surfaces, std::uint32_t pixel) const;
  void begin(const PixelRay& pixel_ray, std::uint32_t pixel);
  void follow(const PixelRays& pixel_rays, Surfaces& surfaces);

  const ProjectedLayer* view_;
  const TriangleBins* bins_;
  std::uint32_t layer_;
  Entries entries_;
  SmoothCells cells_;
  bool anchored_ = false; // they are found
  std::vector<Ray> rays_;
  std::vector<MarchRay> march_rays_;
  std::vector<float> begin_;
  std::vector<MarchRun> runs_;
  kernels::PointLanes points_, positions_; // of what the rays have met
};

} // namespace kinora::fields
