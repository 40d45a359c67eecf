// A still camera's capture as if a hand had held the camera: each frame is turned about the camera's centre, which
// keeps what it shows exact, and cut so that its borders stay filled.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>

#include "ingest/capture/capture.h"
#include "ingest/depth/depth_cleaning.h"

namespace kinora::bench {

/// Where the hand turns the camera in frame i of a capture at 30 frames a second: up to `degrees` to either side within
/// two seconds, less up and down and about its axis. Frame 0 is the identity.
inline SE3 sway(int i, double degrees) {
  const double t = 2 * std::numbers::pi * i / 30;
  const double a = degrees * std::numbers::pi / 180;
  SE3 pose = SE3::Identity();
  pose.rotate(Eigen::AngleAxisd(a * std::sin(0.5 * t), Eigen::Vector3d::UnitY()));
  pose.rotate(Eigen::AngleAxisd(0.6 * a * std::sin(0.8 * t), Eigen::Vector3d::UnitX()));
  pose.rotate(Eigen::AngleAxisd(0.4 * a * std::sin(0.65 * t), Eigen::Vector3d::UnitZ()));
  return pose;
}

class MovingCapture final : public ingest::Capture {
public:
  /// `has_poses`: the frames tell where the camera is.
  MovingCapture(std::unique_ptr<ingest::Capture> still, double degrees, bool has_poses)
      : still_(std::move(still)), info_(still_->info()), degrees_(degrees) {
    info_.has_poses = has_poses;
    const Intrinsics& k = info_.intrinsics;
    const double a = degrees * std::numbers::pi / 180;
    left_ = std::min(k.width / 4, static_cast<int>(kSpare * (k.fx * std::tan(a) + 0.5 * k.height * std::sin(0.4 * a))));
    top_ = std::min(k.height / 4,
                    static_cast<int>(kSpare * (k.fy * std::tan(0.6 * a) + 0.5 * k.width * std::sin(0.4 * a))));
    info_.intrinsics = {k.width - 2 * left_, k.height - 2 * top_, k.fx, k.fy, k.cx - left_, k.cy - top_};
  }

  const ingest::CaptureInfo& info() const override { return info_; }
  const std::vector<ingest::SkippedFrame>& skipped() const override { return still_->skipped(); }

  std::optional<ingest::Frame> next() override {
    std::optional<ingest::Frame> seen = still_->next();
    if (!seen) return seen;
    ingest::Frame frame;
    frame.index = seen->index;
    frame.time = seen->time;
    frame.camera.intrinsics = info_.intrinsics;
    if (info_.has_poses) frame.camera.camera_to_world = sway(frame.index, degrees_);
    rotate_frame(*seen, sway(frame.index, degrees_).linear(), frame);
    frame.clean_depth = ingest::clean_depth(frame.depth, info_.intrinsics);
    return frame;
  }

private:
  void rotate_frame(const ingest::Frame& seen, const Eigen::Matrix3d& to_still, ingest::Frame& frame) const {
    const Intrinsics& k = info_.intrinsics;
    const Intrinsics& still = seen.camera.intrinsics;
    frame.color = ColorImage(k.width, k.height, 3);
    frame.depth = DepthImage(k.width, k.height);
    if (seen.has_labels()) frame.labels = LabelImage(k.width, k.height);
    for (int v = 0; v < k.height; ++v) {
      for (int u = 0; u < k.width; ++u) {
        const Eigen::Vector3d ray = to_still * k.unproject(u, v, 1);
        const Eigen::Vector2d pixel = still.project(ray);
        const int x = static_cast<int>(std::lround(pixel.x()));
        const int y = static_cast<int>(std::lround(pixel.y()));
        if (!seen.depth.contains(x, y)) continue;
        frame.depth.at(u, v) = seen.depth.at(x, y) / static_cast<float>(ray.z());
        if (seen.has_labels()) frame.labels.at(u, v) = seen.labels.at(x, y);
        mix(seen.color, pixel, frame.color.pixel(u, v));
      }
    }
  }

  static void mix(const ColorImage& color, const Eigen::Vector2d& pixel, std::uint8_t* result) {
    const int x = std::clamp(static_cast<int>(std::floor(pixel.x())), 0, color.width() - 2);
    const int y = std::clamp(static_cast<int>(std::floor(pixel.y())), 0, color.height() - 2);
    const double a = std::clamp(pixel.x() - x, 0.0, 1.0);
    const double b = std::clamp(pixel.y() - y, 0.0, 1.0);
    for (int c = 0; c < 3; ++c) {
      const double above = (1 - a) * color.at(x, y, c) + a * color.at(x + 1, y, c);
      const double below = (1 - a) * color.at(x, y + 1, c) + a * color.at(x + 1, y + 1, c);
      result[c] = static_cast<std::uint8_t>(std::lround((1 - b) * above + b * below));
    }
  }

  static constexpr double kSpare = 1.15; ///< corners move farther than the middles of the sides

  std::unique_ptr<ingest::Capture> still_;
  ingest::CaptureInfo info_;
  double degrees_;
  int left_ = 0;
  int top_ = 0;
};

} // namespace kinora::bench
