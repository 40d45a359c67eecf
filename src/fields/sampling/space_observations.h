// What the pixels of all frames see of a layer's occupied space: where it is empty, and where a pixel without depth
// first meets it.
#pragma once

#include <cstdint>

#include "core/large_buffer.h"
#include "core/sensor_noise.h"
#include "fields/model/field.h"
#include "fields/network/vector_features.h"
#include "fields/sampling/layer_observations.h"
#include "fields/sampling/occupancy.h"

namespace kinora::fields {

/// A short piece of a pixel's ray in occupied space.
struct RaySegment {
  std::uint32_t pixel; ///< index into PixelStore::pixels()
  FieldRay ray;        ///< its ray near the piece, relative to the field's box
  Interval segment;    ///< depths for which `ray` holds; the rest of a deforming layer's ray is another line
};

struct UnmeasuredRaySegment : RaySegment {
  PackedRotation rotation; ///< of the layer there
};

struct SpaceObservations {
  LargeBuffer<UnmeasuredRaySegment> unmeasured; ///< own pixels without depth, where their ray first meets the layer
  LargeBuffer<RaySegment> free_space;           ///< pieces of rays before the measured surface
};

/// Occupied cells are carried to where they are in each frame, which needs no search for a way back: the pixel that
/// looks through one says whether it is before a surface. Other layers' pixels say so up to their own surface
/// (free_space_until), those of a layer that deforms up to the band about it: own rays of others have free samples. Not
/// every cell is carried into every frame where that would be more than some millions. `noise`: LossWeights::noise.
SpaceObservations observe_occupied_space(const LayerObservations& layer, const FieldConfig& config,
                                         const Occupancy& occupancy, float near_depth, SensorNoise noise = {});

} // namespace kinora::fields
