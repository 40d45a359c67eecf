// Pixels that teach a deforming layer, carried into its canonical space once and kept: poses of stored frames do not
// change. Near the surface that it measures a ray becomes two halves of parabolas there; in the space before it,
// a short straight piece.
#pragma once

#include <array>
#include <cstdint>

#include "fields/field.h"
#include "fields/occupancy.h"
#include "fields/pixel_store.h"
#include "tracking/motion.h"

namespace kinora::fields {

struct WarpedPixel {
  std::uint32_t pixel; ///< index into PixelStore::pixels()
  FieldRay ray;        ///< its ray near the layer, relative to the field's box
  Interval piece;      ///< depths for which `ray` holds; the rest of the pixel's ray is another line
  /// What the ray leaves its straight line by, for each squared metre of depth before and behind the measured surface.
  std::array<std::array<float, 3>, 2> bends{};
};

/// The layer's own pixels with measured (also doubtful) depth, their rays as they are about that depth. Pixels of lost
/// frames and those that no node carries are left out.
LargeBuffer<WarpedPixel> warp_measured_pixels(const PixelStore& pixels, int label, const tracking::Motion& motion,
                                              const FieldConfig& config);

/// What other pixels say of the layer's occupied space.
struct WarpedSpace {
  LargeBuffer<WarpedPixel> unmeasured; ///< own pixels without depth, where their ray first meets the layer
  LargeBuffer<WarpedPixel> before;     ///< pieces of rays in occupied space before the measured surface: empty
};

/// Every occupied cell is carried to where it is in each frame, which needs no search for the way back: the pixel that
/// looks through it says whether it is before a surface.
WarpedSpace warp_occupied_space(const PixelStore& pixels, int label, const tracking::Motion& motion,
                                const FieldConfig& config, const Occupancy& occupancy, float near_depth);

} // namespace kinora::fields
