// What was seen of one layer: the stored pixels, which of them are its own, and where it was in each frame.
#pragma once

#include "fields/sampling/pixel_store.h"
#include "motion/motion.h"

namespace kinora::fields {

/// All that a layer's field is made from. A view: pixels and motion must outlive it.
struct LayerObservations {
  const PixelStore& pixels; ///< of all layers: those of others tell where this one is not
  int label;                ///< of the layer's own pixels; 0 takes all of them where nothing is labelled
  const motion::Motion& motion;

  bool is_foreground(const StoredPixel& pixel) const { return pixel.label == label; }
  /// Nothing is known of where the layer was then.
  bool is_lost(const StoredFrame& frame) const {
    return motion.health(static_cast<std::size_t>(frame.frame)) == motion::Health::kLost;
  }
  bool deforms() const { return motion.kind() == motion::MotionKind::kDeforming; }
};

} // namespace kinora::fields
