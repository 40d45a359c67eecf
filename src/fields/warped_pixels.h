// Pixels that teach a deforming layer, carried into its canonical space once and kept: poses of stored frames do not
// change, and along the few centimetres that matter a ray stays straight.
#pragma once

#include <cstdint>
#include <vector>

#include "fields/field.h"
#include "fields/occupancy.h"
#include "fields/pixel_store.h"
#include "tracking/motion.h"

namespace kinora::fields {

struct WarpedPixel {
  std::uint32_t pixel; ///< index into PixelStore::pixels()
  FieldRay ray;        ///< its ray near the layer, relative to the field's box
  Interval piece;      ///< depths for which `ray` holds; the rest of the pixel's ray is another straight line
};

/// The layer's own pixels with measured (also doubtful) depth, their rays straightened at that depth. Pixels of lost
/// frames and those farther than the graph's influence from every node are left out.
LargeBuffer<WarpedPixel> warp_measured_pixels(const PixelStore& pixels, int label, const tracking::Motion& motion,
                                              const FieldConfig& config);

/// What other pixels say of the layer's occupied space.
struct WarpedSpace {
  LargeBuffer<WarpedPixel> unmeasured; ///< own pixels without depth, where their ray first meets the layer
  LargeBuffer<WarpedPixel> before;     ///< pieces of rays in occupied space before the measured surface: empty
};

WarpedSpace warp_occupied_space(const PixelStore& pixels, int label, const tracking::Motion& motion,
                                const FieldConfig& config, const Occupancy& occupancy, float near_depth);

} // namespace kinora::fields
