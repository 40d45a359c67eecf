#include "player/window/orbit_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kinora::player::window {

Intrinsics fitted(const Intrinsics& capture, int width, int height) {
  const double scale =
      std::min(static_cast<double>(width) / capture.width, static_cast<double>(height) / capture.height);
  const int inner_width = std::clamp(static_cast<int>(std::lrint(scale * capture.width)), 1, width);
  const int inner_height = std::clamp(static_cast<int>(std::lrint(scale * capture.height)), 1, height);
  Intrinsics out = capture.resized(inner_width, inner_height);
  out.width = width;
  out.height = height;
  out.cx += (width - inner_width) / 2.0;
  out.cy += (height - inner_height) / 2.0;
  return out;
}

Camera OrbitCamera::camera(int width, int height) const { return {fitted(home_.intrinsics, width, height), pose()}; }

SE3& OrbitCamera::moving_pose() {
  if (!pose_) {
    pose_ = home_.camera_to_world;
    down_ = pose_->linear().col(1);
  }
  return *pose_;
}

void OrbitCamera::orbit(double right, double down) {
  constexpr double kPole = 0.05; // radians between the line of sight and the vertical
  SE3& pose = moving_pose();
  const Eigen::Vector3d centre = pivot_ + pan_;
  const double to_down = std::acos(std::clamp(pose.linear().col(2).dot(down_), -1.0, 1.0));
  // The mouse goes down: the camera rises and looks further down.
  const double tilt = std::clamp(std::numbers::pi * down, kPole - (std::numbers::pi - to_down), to_down - kPole);
  const bool tilts = kPole < to_down && to_down < std::numbers::pi - kPole;
  const Eigen::AngleAxisd about_vertical(std::numbers::pi * right, down_);
  const Eigen::AngleAxisd about_right(tilts ? -tilt : 0.0, Eigen::Vector3d(pose.linear().col(0)));
  pose =
      renormalized(Eigen::Translation3d(centre) * about_vertical * about_right * Eigen::Translation3d(-centre) * pose);
}

void OrbitCamera::pan(double right, double down) {
  SE3& pose = moving_pose();
  const double distance = (pivot_ + pan_ - pose.translation()).norm();
  // The window's height in metres at that distance.
  const double height = distance * home_.intrinsics.height / home_.intrinsics.fy;
  const Eigen::Vector3d step = -height * (right * pose.linear().col(0) + down * pose.linear().col(1));
  pose.translation() += step;
  pan_ += step;
}

void OrbitCamera::zoom(double steps) {
  constexpr double kNearest = 0.05, kFarthest = 100; // metres
  SE3& pose = moving_pose();
  const Eigen::Vector3d centre = pivot_ + pan_;
  const Eigen::Vector3d from = pose.translation() - centre;
  const double distance = from.norm();
  if (distance <= 0) return;
  const double wanted = std::clamp(distance * std::pow(0.9, steps), kNearest, kFarthest);
  pose.translation() = centre + from * (wanted / distance);
}

void OrbitCamera::reset() {
  pose_.reset();
  pan_.setZero();
}

} // namespace kinora::player::window
