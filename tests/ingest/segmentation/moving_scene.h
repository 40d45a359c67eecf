// A room with a floor, a wall and a body that walks, as a camera with noise sees it.
#pragma once

#include <numbers>

#include "core/random.h"
#include "core/sensor_noise.h"
#include "ingest/segmentation/segmenter.h"

namespace kinora::ingest {

/// Pixels that both have of a label over those that either has; 1 if neither has any.
inline double overlap(const LabelImage& a, const LabelImage& b, int label) {
  double both = 0;
  double any = 0;
  for (std::size_t i = 0; i < a.pixel_count(); ++i) {
    both += a.data()[i] == label && b.data()[i] == label ? 1 : 0;
    any += a.data()[i] == label || b.data()[i] == label ? 1 : 0;
  }
  return any == 0 ? 1 : both / any;
}

struct MovingScene {
  int frames = 24;
  bool has_body = true;  ///< a round body, wider than a limb, that walks to the right
  double speed = 0.03;   ///< metres per frame
  bool warped = false;   ///< a hand moves and turns the camera, and its frames tell where it is …
  double told_wrong = 0; ///< … but for so many millimetres, and tenths of a degree, standard deviation of each axis

  static Intrinsics intrinsics() { return {160, 120, 140, 140, 79.5, 59.5}; }

  /// Where the body's axis stands at frame i (metres).
  double body_x(int i) const { return -0.35 + speed * i; }

  SE3 camera_to_world(int i) const {
    SE3 pose = SE3::Identity();
    if (!warped) return pose;
    pose.translation() = Eigen::Vector3d(0.25 * std::sin(0.3 * i), 0.04 * std::sin(0.5 * i), 0);
    pose.rotate(Eigen::AngleAxisd(-0.1 * std::sin(0.3 * i), Eigen::Vector3d::UnitY()));
    return pose;
  }

  /// Where frame i says that the camera was.
  SE3 told_pose(int i) const {
    Random random(23, static_cast<std::uint64_t>(i));
    Twist error;
    for (double& axis : error) axis = random.normal();
    error.head<3>() *= told_wrong * 1e-3;
    error.tail<3>() *= told_wrong * 0.1 * std::numbers::pi / 180;
    return camera_to_world(i) * exp_se3(error);
  }

  Frame frame(int i, LabelImage* truth = nullptr) const {
    const Intrinsics k = intrinsics();
    Frame frame;
    frame.index = i;
    frame.time = i / 30.0;
    frame.camera = {k, camera_to_world(i)};
    const Eigen::Vector3d eye = frame.camera.camera_to_world.translation();
    frame.color = ColorImage(k.width, k.height, 3);
    frame.depth = DepthImage(k.width, k.height);
    if (truth != nullptr) *truth = LabelImage(k.width, k.height);
    Random random(17, static_cast<std::uint64_t>(i));
    for (int v = 0; v < k.height; ++v) {
      for (int u = 0; u < k.width; ++u) {
        const Eigen::Vector3d ray = frame.camera.camera_to_world.linear() * k.unproject(u, v, 1);
        double z = (2.5 - eye.z()) / ray.z(); // the wall
        int color[3] = {200, 200, 190};
        if (const double floor = ray.y() > 0 ? (0.8 - eye.y()) / ray.y() : 100; floor < z) {
          z = floor;
          color[0] = 120, color[1] = 90, color[2] = 60;
        }
        if (const double body = body_depth(ray, Eigen::Vector3d(body_x(i), 0.1, 1.7) - eye);
            has_body && body > 0 && body < z) {
          z = body;
          color[0] = 40, color[1] = 60, color[2] = 160;
          if (truth != nullptr) truth->at(u, v) = 1;
        }
        frame.depth.at(u, v) = static_cast<float>(z + kSensorNoise.sigma(z) * random.normal());
        for (int c = 0; c < 3; ++c)
          frame.color.at(u, v, c) = static_cast<std::uint8_t>(color[c] + static_cast<int>(random.below(7)) - 3);
      }
    }
    if (told_wrong > 0) frame.camera.camera_to_world = told_pose(i);
    return frame;
  }

private:
  /// An upright ellipsoid, 1.2 m high, 0.5 m wide, as seen from the origin; 0: missed.
  static double body_depth(const Eigen::Vector3d& ray, const Eigen::Vector3d& middle) {
    const Eigen::Vector3d scale(1 / 0.25, 1 / 0.6, 1 / 0.2);
    const Eigen::Vector3d d = ray.cwiseProduct(scale);
    const Eigen::Vector3d c = middle.cwiseProduct(scale);
    const double b = d.dot(c);
    const double root = b * b - d.squaredNorm() * (c.squaredNorm() - 1);
    return root < 0 ? 0 : (b - std::sqrt(root)) / d.squaredNorm();
  }
};

/// The scene as a capture, so that a segmenter can look at it twice.
class SceneCapture final : public Capture {
public:
  SceneCapture(const MovingScene& scene, const FrameRange& range) : scene_(scene), range_(range), next_(range.begin) {
    info_.frame_count = scene.frames;
    info_.intrinsics = MovingScene::intrinsics();
  }
  const CaptureInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    if (next_ >= scene_.frames || !range_.contains(next_)) return std::nullopt;
    Frame frame = scene_.frame(next_);
    next_ += range_.step;
    return frame;
  }
  const std::vector<SkippedFrame>& skipped() const override { return skipped_; }

private:
  MovingScene scene_;
  FrameRange range_;
  int next_;
  CaptureInfo info_;
  std::vector<SkippedFrame> skipped_;
};

} // namespace kinora::ingest
