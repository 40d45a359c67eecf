// Brings the motion of a deforming layer nearer to what its field shows: colour, silhouette and depth of each frame's
// pixels, aligned through a field that was trained with the motion so far. The tracker's model is a voxel wide; a field
// is sharper, and knows all frames.
// Sources: direct alignment as in Engel et al., "Direct Sparse Odometry", TPAMI 40(3), 2018; poses refined through a
// radiance field as in Lin et al., "BARF", ICCV 2021, here for the nodes of a deformation graph and by Gauss–Newton.
#pragma once

#include <cstddef>
#include <span>

#include "core/progress.h"
#include "fields/model/field.h"
#include "fields/sampling/layer_observations.h"
#include "tracking/model/surface_graph.h"

namespace kinora::encode {

struct MotionRefinementConfig {
  int rounds = 2;            ///< Gauss–Newton steps, each with the field looked at anew
  double rigidity = 0.1;     ///< standard deviation of a neighbour's place, in units of the nodes' spacing
  double prior_sigma = 0.01; ///< metres from where the tracker had a node
  int pcg_iterations = 60;
  double pcg_tolerance = 1e-2;
};

struct MotionRefinement {
  std::size_t frames = 0;  ///< in which nodes were moved
  double color_before = 0; ///< typical difference (robust deviation, of 1) of field and pixels, mean over these frames
  double color_after = 0;
};

/// The motion with the nodes of each stored, tracked frame moved so that the field explains its pixels better; frames
/// that are not stored move as their neighbours do. A frame that would be explained worse keeps its nodes. `edges` and
/// `node_spacing` (metres) are those of the motion's graph. Same input, same bits, for any number of threads. Throws
/// Error(kInterrupted) when cancelled.
motion::Motion refine_motion(const fields::Field& field, const fields::LayerObservations& layer,
                             std::span<const tracking::GraphEdge> edges, double node_spacing, Progress& progress,
                             MotionRefinement* report = nullptr, const MotionRefinementConfig& config = {});

} // namespace kinora::encode
