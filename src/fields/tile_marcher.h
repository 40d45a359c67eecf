// From where rays enter a layer to the surfaces that they meet in it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fields/layer_view.h"
#include "fields/march.h"
#include "fields/rasterizer.h"
#include "fields/smooth_cells.h"
#include "fields/surface.h"

namespace kinora::fields {

/// Share of a pixel's light below which a surface is not looked at.
inline constexpr float kNegligible = 0.004F;

using Surfaces = PixelLists<Surface, 8>;

/// Finds the surfaces of one layer in a tile.
class TileMarcher {
public:
  void march(const LayerView& view, std::uint32_t layer, const TriangleBins& bins,
             const std::vector<Eigen::Vector3f>& pixel_rays, const Entries& entries, Surfaces& surfaces);

private:
  struct Ray {
    std::uint32_t pixel;
    std::size_t next; // entry
    bool alone;       // has met nothing yet
    float entry_depth;
    float depth_step;
    Eigen::Vector3f origin, direction;
  };
  // Stands the ray at its next entry that is not one of where it comes from; false if there is none.
  static bool enter(const LayerView& view, const TriangleBins& bins, const Eigen::Vector3f& pixel_ray,
                    const Entries& entries, float until_depth, Ray& ray, float& begin);

  void begin(const LayerView& view, const TriangleBins& bins, const std::vector<Eigen::Vector3f>& pixel_rays,
             const Entries& entries, std::uint32_t pixel);
  void follow(const LayerView& view, std::uint32_t layer, const TriangleBins& bins,
              const std::vector<Eigen::Vector3f>& pixel_rays, const Entries& entries, Surfaces& surfaces);

  SmoothCells cells_;
  std::vector<Ray> rays_;
  std::vector<MarchRay> march_rays_;
  std::vector<float> begin_;
  std::vector<MarchRun> runs_;
  kernels::PointLanes points_, places_; // of what the rays have met
};

} // namespace kinora::fields
