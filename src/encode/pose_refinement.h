// Brings the pose of a still or rigid layer relative to the camera nearer to what its field shows, frame by frame.
// Source: Lin et al., "BARF: Bundle-Adjusting Neural Radiance Fields", ICCV 2021, here by Gauss–Newton.
#pragma once

#include <optional>
#include <vector>

#include "core/progress.h"
#include "encode/field_view.h"

namespace kinora::encode {

struct PoseRefinementConfig {
  int passes = 1;              ///< trainings of a draft, each with poses refined after it; 0: none
  int rounds = 3;              ///< Gauss–Newton steps
  double prior_metres = 0.02;  ///< standard deviation from where the tracker had it
  double prior_radians = 0.02; ///< and of its turn
};

/// What a frame says of the times that reading its rows takes, of colour and of depth, whatever its pose: normal
/// equations, by how many seconds they are longer than was taken.
struct ReadoutEvidence {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero(); ///< 1 / seconds²
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();    ///< 1 / seconds
};

/// How a stored frame's camera comes to lie nearer, seen from the layer.
struct PoseCorrection {
  SE3 canonical_from_camera = SE3::Identity(); ///< refined
  ColorFit fit{};
  ReadoutEvidence readout{};
};

/// One for each stored frame, in the order of the store; nothing where it would be explained no better, or shows too
/// little of the layer. The layer does not deform. `velocities`: of the camera in each frame of the timeline, in its
/// own space. Same input, same bits, for any number of threads. Throws Error(kInterrupted) when cancelled.
std::vector<std::optional<PoseCorrection>> refine_poses(const fields::Field& field,
                                                        const fields::LayerObservations& layer,
                                                        std::span<const Twist> velocities, Progress& progress,
                                                        const PoseRefinementConfig& config = {});

} // namespace kinora::encode
