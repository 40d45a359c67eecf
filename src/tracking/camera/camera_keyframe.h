// A frame that the camera's later places are measured against.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tracking/camera/background_view.h"
#include "tracking/camera/camera_features.h"
#include "tracking/rigid/pose_quality.h"
#include "tracking/rigid/rigid_icp.h"

namespace kinora::tracking {

/// Plain data; thread-safe to read.
struct CameraKeyframe {
  BackgroundFrame frame;          ///< its view can be made again
  std::vector<ModelPoint> points; ///< of the background, in the camera
  double distance = 1;            ///< median depth of the points, metres
  SurfaceFeatures features;       ///< that its place is known again by
};

/// Of each cell of 4×4 pixels the point with the strongest texture, and as many again at most, fairly over the
/// directions of the normal: corners of a room count as much as its walls.
CameraKeyframe make_keyframe(const BackgroundFrame& reduced, const LayerView& view);

/// Where points are in a view, and whether to believe it.
struct CameraFit {
  Alignment alignment;
  PoseQuality quality;
  bool dark = false; ///< the picture does not show the points' texture: geometry alone was aligned

  const SE3& pose() const { return alignment.model_to_camera; }
  /// The view shows the points' surface there.
  bool supported() const;
  /// Complete, and hardly any of the points on the view's surface speaks against it.
  bool certain() const;
  /// Supported, in all directions, and by the picture too if there is texture.
  bool complete() const { return supported() && !dark && alignment.degenerate_directions == 0; }
};

/// Aligns those of the points that the view shows at `expected` (points' space to camera), which is also the prior.
/// `coarsest_level`: as in AlignmentConfig.
CameraFit fit_camera(std::span<const ModelPoint> points, const LayerView& view, const SE3& expected,
                     int coarsest_level = 2);

/// How much the view changes with a motion of the camera: radians, and metres over the distance of what is seen.
double view_change(const SE3& motion, double distance);

/// How far `motion` moves the points as a camera sees them: root mean square, in pixels and σ(z) together. Below one it
/// is less than the camera can tell of a single point. 0 without points.
double visible_shift(std::span<const ModelPoint> points, const Intrinsics& intrinsics, const SE3& motion);

/// The pose b → a (`b_view` is b's) that aligning b's points to a's view finds from `b_to_a` on, if aligning a's points
/// to b's view finds the same one to less than a camera can tell.
std::optional<SE3> relative_pose(const CameraKeyframe& a, const CameraKeyframe& b, const LayerView& b_view,
                                 const SE3& b_to_a);

} // namespace kinora::tracking
