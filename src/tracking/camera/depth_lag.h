// By how much the depth of a moving camera comes later than its colour.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/se3.h"
#include "tracking/rigid/residuals.h"

namespace kinora::tracking {

/// Where a frame is by its depth alone and by its texture alone.
struct DepthAgainstTexture {
  Twist difference = Twist::Zero(); ///< exp_se3 of it leads from the pose by texture to that by depth, in the camera
  Eigen::Matrix<double, 6, 6> certainty = Eigen::Matrix<double, 6, 6>::Zero(); ///< of it: information
};

/// How `view` lies on a model whose points it shows at about `model_to_camera`. Deterministic; thread-safe.
DepthAgainstTexture depth_against_texture(std::span<const ModelPoint> points, const LayerView& view,
                                          const SE3& model_to_camera);

/// One frame on the points of another.
struct LagEvidence {
  std::size_t frame; ///< of the path
  std::size_t keyframe;
  SE3 keyframe_to_camera;
  DepthAgainstTexture measured;
};

/// Seconds by which depth shows what the camera sees later than colour does: its depth lies as from where the camera
/// was so many seconds before, and differently so where it moves otherwise than when the key frame was taken. The lag
/// of least absolute deviations over all frames. Nothing if it cannot be told: too few frames, the camera hardly moves,
/// stretches of the capture do not agree to four standard deviations, or the lag is too small to be seen (2 ms) or too
/// large for two streams of one sensor (100 ms). `path`: camera to world of all frames; `times`: theirs, seconds.
std::optional<double> estimate_depth_lag(std::span<const LagEvidence> evidence, std::span<const SE3> path,
                                         std::span<const double> times);

/// Carries what depth that comes later by `lag` seconds shows into the colour camera, which moves at `velocity`.
inline SE3 depth_to_color(double lag, const Twist& velocity) { return exp_se3(-lag * velocity); }

} // namespace kinora::tracking
