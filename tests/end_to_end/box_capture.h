// A small capture of an analytic scene, drawn by ray casting: a patterned box that moves before a wall and a floor, and
// a ball that is labelled as a person.
#pragma once

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/camera.h"
#include "core/color_gain.h"
#include "core/image_codec.h"
#include "core/random.h"
#include "core/sensor_noise.h"
#include "formats/sample_capture.h"

namespace kinora::test {

struct BoxScene {
  int width = 128;
  int height = 96;
  int frames = 14;
  bool masks = true;
  int box_comes = 0;      ///< the first frame in which the box is there
  int box_leaves = 1'000; ///< the first one after that in which it is not
  double color_zoom = 1;  ///< focal length of the colour camera over that of depth, which calibration gives for both
  bool poses = false;     ///< a camera that moves sideways and tells where it is, over a scene that stands still
  double pose_error = 0;  ///< metres by which each of these poses is told wrong, another way in each frame
  std::array<float, 2> exposures{1, 1}; ///< factors of light, of even and of odd frames
  bool moving_camera = false;           ///< a camera that moves sideways and does not tell, over a scene that moves too

  Intrinsics color_intrinsics() const {
    Intrinsics k = intrinsics();
    k.fx *= color_zoom;
    k.fy *= color_zoom;
    return k;
  }
  Intrinsics intrinsics() const { return {width, height, 120, 120, (width - 1) / 2.0, (height - 1) / 2.0}; }
  SE3 camera_to_world(int frame) const {
    SE3 pose = SE3::Identity();
    if (poses || moving_camera) pose.translation().x() = 0.02 * frame;
    return pose;
  }
  SE3 told_camera_to_world(int frame) const {
    const double angle = 2.4 * frame;
    return SE3(Eigen::Translation3d(pose_error * std::cos(angle), pose_error * std::sin(angle), 0) *
               camera_to_world(frame));
  }
  SE3 box_to_world(int frame) const {
    const double i = poses ? 0 : frame;
    SE3 pose = SE3::Identity();
    pose.translate(Eigen::Vector3d(-0.2 + 0.02 * i, 0.05 - 0.005 * i, 1.3 + 0.01 * i));
    pose.rotate(Eigen::AngleAxisd(0.5 + 0.06 * i, Eigen::Vector3d(0.2, 1, 0.1).normalized()));
    return pose;
  }
};

struct Hit {
  double depth = 1e9; ///< along the optical axis, metres
  int label = 0;
  Eigen::Vector3d color = Eigen::Vector3d::Zero(); ///< 0–255
};

/// A smooth pattern with edges, different along every axis.
inline Eigen::Vector3d pattern(const Eigen::Vector3d& p, double scale) {
  const auto wave = [](double x) { return std::tanh(2 * std::sin(2 * std::numbers::pi * x)); };
  return {128 + 50 * wave(p.x() * scale) + 30 * wave(p.z() * scale * 0.7), 120 + 60 * wave(p.y() * scale + 0.2),
          110 + 50 * wave((p.x() + p.y() - p.z()) * scale * 0.5)};
}

inline void hit_plane(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray, const Eigen::Vector3d& normal,
                      double offset, Hit& hit) {
  const double depth = (offset - normal.dot(origin)) / normal.dot(ray);
  if (depth > 0.1 && depth < hit.depth) hit = {depth, 0, pattern(origin + ray * depth, 1.3)};
}

inline void hit_ball(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray, const Eigen::Vector3d& centre,
                     double radius, Hit& hit) {
  const Eigen::Vector3d to_centre = origin - centre;
  const double a = ray.squaredNorm();
  const double b = ray.dot(to_centre);
  const double root = b * b - a * (to_centre.squaredNorm() - radius * radius);
  if (root < 0) return;
  const double depth = (-b - std::sqrt(root)) / a;
  if (depth > 0.1 && depth < hit.depth) hit = {depth, 1, {200, 160, 140}};
}

inline void hit_box(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray, const SE3& box_to_world, Hit& hit) {
  const Eigen::Vector3d half(0.24, 0.18, 0.15);
  const SE3 inverse = box_to_world.inverse();
  const Eigen::Vector3d o = inverse * origin;
  const Eigen::Vector3d d = inverse.linear() * ray;
  double enter = 0.1;
  double leave = hit.depth;
  for (int k = 0; k < 3; ++k) {
    const double a = (-half[k] - o[k]) / d[k];
    const double b = (half[k] - o[k]) / d[k];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter < leave) hit = {enter, 2, pattern(o + d * enter, 6)};
}

inline Hit cast_ray(const BoxScene& scene, int frame, int u, int v, const Intrinsics& camera_intrinsics) {
  const SE3 camera = scene.camera_to_world(frame);
  const Eigen::Vector3d ray = camera.linear() * camera_intrinsics.unproject(u, v, 1);
  const Eigen::Vector3d origin = camera.translation();
  Hit hit;
  hit_plane(origin, ray, Eigen::Vector3d::UnitZ(), 2.0, hit);
  hit_plane(origin, ray, Eigen::Vector3d::UnitY(), 0.6, hit);
  hit_ball(origin, ray, {0.45, 0.1 + 0.01 * frame, 1.4}, 0.15, hit);
  if (frame >= scene.box_comes && frame < scene.box_leaves) hit_box(origin, ray, scene.box_to_world(frame), hit);
  return hit;
}

inline std::string matrix_text(const SE3& pose, char between_rows = '\n') {
  std::string text;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) {
      text += fmt::format("{:.9f}", pose(r, c)) + (c < 3 ? ' ' : r < 3 ? between_rows : '\n');
    }
  }
  return text;
}

/// Colour and depth with the sensor's noise, and masks.
inline void write_frame(const TemporaryFolder& folder, const BoxScene& scene, int frame) {
  ColorImage color(scene.width, scene.height, 3);
  DepthImage16 depth(scene.width, scene.height);
  ColorImage labels(scene.width, scene.height, 1);
  Random random(5, static_cast<std::uint64_t>(frame));
  for (int v = 0; v < scene.height; ++v) {
    for (int u = 0; u < scene.width; ++u) {
      const Hit hit = cast_ray(scene, frame, u, v, scene.intrinsics());
      const Eigen::Vector3d shown = cast_ray(scene, frame, u, v, scene.color_intrinsics()).color;
      for (int c = 0; c < 3; ++c) {
        color.at(u, v, c) = static_cast<std::uint8_t>(std::clamp(shown[c] + random.normal(), 0.0, 255.0));
      }
      const double noisy = hit.depth + random.normal() * kSensorNoise.sigma(hit.depth);
      depth.at(u, v) = static_cast<std::uint16_t>(std::lround(1000 * noisy));
      labels.at(u, v) = static_cast<std::uint8_t>(hit.label);
    }
  }
  const float exposure = scene.exposures[static_cast<std::size_t>(frame) % 2];
  GainTables(ColorGain{{exposure, exposure, exposure}}).apply_to(color);
  const std::string name = six_digits(frame);
  if (scene.poses) {
    const std::string stem = "frame-" + name;
    folder.write(stem + ".color.png", encode_png(color));
    folder.write(stem + ".depth.png", encode_png16(depth));
    folder.write(stem + ".pose.txt", matrix_text(scene.told_camera_to_world(frame)));
    return;
  }
  folder.write("color/" + name + ".png", encode_png(color));
  folder.write("depth/" + name + ".png", encode_png16(depth));
  if (scene.masks) folder.write("mask/" + name + ".png", encode_png(labels));
}

/// All frames, calibration, and the box's true poses in the camera in gt/.
inline void write_box_capture(const TemporaryFolder& folder, const BoxScene& scene) {
  const Intrinsics camera = scene.intrinsics();
  const std::string size =
      "\"width\": " + std::to_string(scene.width) + ", \"height\": " + std::to_string(scene.height);
  folder.write("intrinsics.json", "{" + size + ", \"fx\": 120, \"fy\": 120, \"cx\": " + std::to_string(camera.cx) +
                                      ", \"cy\": " + std::to_string(camera.cy) +
                                      ", \"depth_factor\": 1000, \"fps\": 30}");
  std::string poses;
  for (int i = 0; i < scene.frames; ++i) {
    write_frame(folder, scene, i);
    poses += std::to_string(i) + " " + std::to_string(i / 30.0) + " " +
             matrix_text(scene.camera_to_world(i).inverse() * scene.box_to_world(i), ' ');
  }
  if (!scene.poses) folder.write("gt/object_pose.txt", poses);
}

} // namespace kinora::test
