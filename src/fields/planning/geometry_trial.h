// Which geometry suits a layer: each is trained for a while on a part of the layer's pixels, and judged by what it
// draws where frames were left out.
#pragma once

#include "fields/training/trainer.h"

namespace kinora::fields {

/// How far drawings are from the pixels of frames that were not trained on.
struct DrawingError {
  double color = 0; ///< root of the mean square for each of the layer's pixels with any depth, of 255, on black: what
                    ///< is drawn in front of other pixels should be black, too
  double depth = 0; ///< metres, median over the layer's pixels with measured depth
};

struct GeometryTrial {
  Geometry chosen = Geometry::kDensity;
  DrawingError density, signed_distance;
  std::size_t rays = 0;   ///< that both were trained with
  std::size_t frames = 0; ///< left out and drawn; with 0 nothing could be tried
};

/// The smaller colour error wins; where they differ by less than 0.3 %, the smaller depth error.
Geometry better_geometry(const DrawingError& density, const DrawingError& signed_distance);

/// Tries both. Same input, same choice, for any number of threads. `trainer` is that of the whole training, of which a
/// trial takes a small share. Throws Error(kInterrupted) when cancelled.
GeometryTrial try_geometries(const LayerObservations& layer, const FieldConfig& config, const TrainerConfig& trainer,
                             Progress& progress);

} // namespace kinora::fields
