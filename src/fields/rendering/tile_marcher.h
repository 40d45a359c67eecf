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

/// Finds the surfaces of one layer in a tile.
class TileMarcher {
public:
  /// What it is made from must outlive it.
  TileMarcher(const ProjectedLayer& view, std::uint32_t layer, const TriangleBins& bins)
      : view_(&view), bins_(&bins), layer_(layer) {}

  /// To be filled before anything is marched.
  Entries& entries() { return entries_; }
  /// First in each tile: adds the surfaces at the anchors of SmoothCells.
  void march_anchors(const PixelRays& pixel_rays, Surfaces& surfaces);
  /// Adds the surfaces of those pixels that are no anchors.
  void march(const PixelRays& pixel_rays, std::span<const std::uint32_t> pixels, Surfaces& surfaces);

private:
  struct Ray {
    std::uint32_t pixel;
    std::size_t next;     // entry
    bool is_unobstructed; // has met nothing yet
    float entry_depth;
    float depth_step;
    Eigen::Vector3f origin, direction;
    Rotation rotation;
  };
  // Stands the ray at its next entry that is not one of where it comes from; false if there is none.
  bool enter(const PixelRay& pixel_ray, float until_depth, Ray& ray, float& begin) const;

  void begin(const PixelRay& pixel_ray, std::uint32_t pixel);
  void follow(const PixelRays& pixel_rays, Surfaces& surfaces);

  const ProjectedLayer* view_;
  const TriangleBins* bins_;
  std::uint32_t layer_;
  Entries entries_;
  SmoothCells cells_;
  std::vector<Ray> rays_;
  std::vector<MarchRay> march_rays_;
  std::vector<float> begin_;
  std::vector<MarchRun> runs_;
  kernels::PointLanes points_, positions_; // of what the rays have met
};

} // namespace kinora::fields
