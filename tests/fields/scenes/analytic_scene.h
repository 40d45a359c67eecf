// A small scene whose frames are known exactly, for tests that train.
#pragma once

#include "fields/training/trainer.h"

namespace kinora::fields {

constexpr int kWidth = 80;
constexpr int kHeight = 60;

/// A chequered ball of radius 0.3 m in front of a striped wall, seen from a camera that circles it.
struct Scene {
  Eigen::Vector3d centre{0, 0, 2};
  double radius = 0.3;
  double wall = 2.6;
  double waves = 20; ///< of the chequers, radians per metre

  ingest::Frame frame(int index, double angle) const {
    ingest::Frame f;
    f.index = index;
    f.camera.intrinsics = {kWidth, kHeight, 80, 80, (kWidth - 1) / 2.0, (kHeight - 1) / 2.0};
    f.camera.camera_to_world = SE3::Identity();
    f.camera.camera_to_world.translate(centre)
        .rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()))
        .translate(-centre);
    f.color = ColorImage(kWidth, kHeight, 3);
    f.depth = DepthImage(kWidth, kHeight);
    f.labels = LabelImage(kWidth, kHeight);
    shade(f);
    f.clean_depth = f.depth;
    return f;
  }

  /// Colour, depth and labels as the frame's camera sees them.
  void shade(ingest::Frame& f) const {
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) shade(f, u, v);
    }
  }

private:
  void shade(ingest::Frame& f, int u, int v) const {
    const Eigen::Vector3d o = f.camera.camera_to_world.translation();
    const Eigen::Vector3d d = f.camera.camera_to_world.linear() * f.camera.intrinsics.unproject(u, v, 1);
    const Eigen::Vector3d oc = o - centre;
    const double b = oc.dot(d) / d.squaredNorm();
    const double disc = b * b - (oc.squaredNorm() - radius * radius) / d.squaredNorm();
    double depth = (wall - o.z()) / d.z();
    const bool ball = disc > 0;
    if (ball) depth = -b - std::sqrt(disc);
    const Eigen::Vector3d p = o + depth * d;
    const double wave = 0.5 + 0.4 * std::sin((ball ? 1 : 0.4) * waves * p.x()) * (ball ? std::cos(waves * p.y()) : 1.0);
    const Eigen::Vector3d rgb = ball ? Eigen::Vector3d(wave, 0.3, 1 - wave) : Eigen::Vector3d(0.2, wave, 0.4);
    for (int c = 0; c < 3; ++c) f.color.at(u, v, c) = static_cast<std::uint8_t>(std::lround(255 * rgb[c]));
    f.depth.at(u, v) = static_cast<float>(depth);
    f.labels.at(u, v) = ball ? 2 : 0;
  }
};

inline PixelStore store_of(const Scene& scene) {
  PixelStore store(1'000'000, 12);
  for (int i = 0; i < 12; ++i) store.add(scene.frame(i, 0.05 * (i - 6)), i);
  return store;
}

inline TrainerConfig short_training() {
  TrainerConfig trainer;
  trainer.rays = 500'000;
  trainer.rays_per_step = 1024;
  return trainer;
}

} // namespace kinora::fields
