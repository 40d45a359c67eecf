// A camera that a person turns around what the scene is about.
#pragma once

#include <optional>

#include "core/camera.h"

namespace kinora::player::window {

/// The picture of `capture` as large as it fits into a window, in its middle; what the window has beside it shows more.
Intrinsics fitted(const Intrinsics& capture, int width, int height);

/// Stands where the capture camera stands until it is moved; then it stays where it was put. Distances in metres, of
/// the mouse as fractions of the window's height.
class OrbitCamera {
public:
  /// `home`: the capture camera of the shown frame; `pivot`: in world coordinates.
  OrbitCamera(const Camera& home, const Eigen::Vector3d& pivot) : home_(home), pivot_(pivot) {}

  /// The capture camera of another frame.
  void set_home(const Camera& home) { home_ = home; }
  bool moved() const { return pose_.has_value(); }
  Camera camera(int width, int height) const;

  /// A drag over the whole height turns by half a circle; what is seen follows the mouse. Never over the poles.
  void orbit(double right, double down);
  /// What lies as far away as the pivot follows the mouse.
  void pan(double right, double down);
  /// Each step goes a tenth of the way towards the pivot, or back; never through it.
  void zoom(double steps);
  void reset();

private:
  SE3& moving_pose();
  const SE3& pose() const { return pose_ ? *pose_ : home_.camera_to_world; }

  Camera home_;
  Eigen::Vector3d pivot_;
  Eigen::Vector3d pan_ = Eigen::Vector3d::Zero();   ///< of the pivot
  Eigen::Vector3d down_ = Eigen::Vector3d::UnitY(); ///< of the capture camera that was left
  std::optional<SE3> pose_;
};

} // namespace kinora::player::window
