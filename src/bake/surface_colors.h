// The colour of a field at its surface.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/field_sampler.h"
#include "core/progress.h"
#include "motion/motion.h"

namespace kinora::bake {

/// A point at the surface, canonical, and the unit vector out of it.
struct SurfacePoint {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;
};

/// For each point the colour (sRGB) that a ray against the normal composites from `before` metres in front of the point
/// until four cells of the field's finest level behind it, in the mean of what light the layer stands in during the
/// clip. Uses all threads; same bits for any number of them. Throws Error(kInterrupted).
std::vector<std::array<std::uint8_t, 3>> surface_colors(const FieldSampler& sampler, const motion::Motion& motion,
                                                        std::span<const SurfacePoint> points, double before,
                                                        const Progress& progress);

} // namespace kinora::bake
