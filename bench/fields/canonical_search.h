// What ways to find canonical positions have in common, so that they can be measured side by side.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "motion/influence_table.h"
#include "motion/warp.h"

namespace kinora::bench {

inline constexpr int kSamples = 8; ///< of a ray, spread over the band about its surface

/// A pixel's ray about the surface that it measures, metres of the world.
struct SearchRay {
  int u, v;     ///< the pixel
  double depth; ///< of the surface
  Eigen::Vector3d surface;
  Eigen::Vector3d direction;           ///< for a metre of depth
  double reach;                        ///< half the band, metres of depth
  std::array<double, kSamples> behind; ///< where the samples lie, from the surface

  Eigen::Vector3d at(double t) const { return surface + t * direction; }
};

/// A deforming layer in one frame.
struct Instant {
  motion::Warp warp;
  std::shared_ptr<const motion::InfluenceTable> table;
  Camera camera;
};

/// Of all samples of all rays; nothing where none is found.
using Positions = std::vector<std::optional<Eigen::Vector3d>>;

/// Not thread-safe.
class CanonicalSearch {
public:
  virtual ~CanonicalSearch() = default;
  /// Once for each frame. The instant must outlive what is found in it.
  virtual void prepare(const Instant& instant) = 0;
  /// Appends the canonical places of the samples in the instant that was prepared last.
  virtual void find(const std::vector<SearchRay>& rays, Positions& positions) = 0;
};

} // namespace kinora::bench
