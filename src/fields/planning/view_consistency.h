// How well the views of a layer agree on where it is: what training may ask of them follows from it.
#pragma once

#include "fields/sampling/layer_observations.h"
#include "fields/training/loss.h"
#include "fields/training/trainer.h"

namespace kinora::fields {

struct ViewConsistency {
  std::size_t observations = 0; ///< measured points of the layer looked at by cameras of other frames
  /// Share of the looks that meet something farther in the point's pixel and in all about it, as far as the sensor's
  /// noise may have moved the point and one pixel more: the mask, a pose or the motion is wrong in one of the two
  /// frames. 0 without looks.
  double free_space_violations = 0;
  /// Standard deviation of the layer's measured depths, poses and motion included, in those of the sensor: from how far
  /// behind a point, in the median of those that lie before it, its pixel sees the layer in another frame. (Points
  /// behind what is seen may be hidden by it.) 0 without looks.
  double noise = 0;
};

/// A spread of measured points of the layer, carried into a spread of other frames. Takes some ten milliseconds.
ViewConsistency measure_view_consistency(const LayerObservations& layer);

/// Opacity and depth of a layer's own rays are asked for twice as strongly where all views agree, and half as many rays
/// tell of emptiness, so that surfaces are found with fewer rays; where masks or motion contradict each other that
/// would make silhouettes grow. In between all follow in proportion to what is seen through, emptiness sooner
/// (docs/experiments/fields.md). Noise beyond the sensor's, and beyond the usual weights', widens the bands in which
/// surfaces are expected.
LossWeights weights_for(const ViewConsistency& consistency, const LossWeights& usual = {});

/// A training that asks of the views what they hold, and else is as usual: weights_for, and
/// - unless enough looks agree, cells that are seen past are dropped in the end (space_carving.h), if they usually are;
/// - where they do, and far better than the sensor's noise lets expect, depths are taken as exact.
void adapt_to(const ViewConsistency& consistency, const TrainerConfig& usual, TrainerConfig& trainer);

} // namespace kinora::fields
