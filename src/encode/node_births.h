// When the nodes of a deforming layer are born: parts that come into view late are not in the clip before.
#pragma once

#include "fields/sampling/layer_observations.h"
#include "motion/node_births.h"

namespace kinora::encode {

/// The births of the nodes that move `observations`, which deform. A node is born when a pixel of the layer first shows
/// surface that hangs on it, or on a node no farther than `reach` metres from it: those hold it, so that it is believed
/// where it guesses to be. Surface that none of them ever showed is born with the nearest that was shown. What is there
/// a few frames after the first pixels counts as there from the start.
motion::NodeBirths node_births(const fields::LayerObservations& observations, double reach);

} // namespace kinora::encode
