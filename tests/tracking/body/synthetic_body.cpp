#include "tracking/body/synthetic_body.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "core/sensor_noise.h"

namespace kinora::tracking::testing {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kWall = 4;

// Where a ray (of unit z) meets a part, as depth along the optical axis. Distances are good to first order only where
// parts are flattened, so steps are short.
double trace(const BodyInCamera& body, std::size_t part, const Vec& ray) {
  const PartShape& shape = body.body().parts[part];
  const Vec centre = body.bone(part) * shape.centre;
  const double nearest = centre.dot(ray) / ray.squaredNorm();
  if ((nearest * ray - centre).norm() > shape.reach) return kWall;
  const double before = shape.reach / ray.norm();
  for (double z = nearest - before; z < nearest + before;) {
    const double distance = closest_surface(shape, body.to_bone(part) * (z * ray)).distance;
    if (distance < 1e-3) return z;
    z += 0.6 * distance / ray.norm();
  }
  return kWall;
}

double trace(const BodyInCamera& body, const Vec& ray) {
  double depth = kWall;
  for (std::size_t part = 0; part < kBodyParts; ++part) depth = std::min(depth, trace(body, part, ray));
  return depth;
}

} // namespace

ingest::Frame render_body(const BodyState& state, const BodyScene& scene) {
  ingest::Frame frame;
  frame.camera.intrinsics = {scene.width, scene.height,      scene.focal,
                             scene.focal, scene.width / 2.0, scene.height / 2.0};
  frame.color = ColorImage(scene.width, scene.height, 3, 128);
  frame.depth = DepthImage(scene.width, scene.height);
  frame.labels = LabelImage(scene.width, scene.height);
  const BodyInCamera body(state);
  parallel_for(static_cast<std::size_t>(scene.height), 4, [&](const Chunk& chunk) {
    for (int v = static_cast<int>(chunk.begin); v < static_cast<int>(chunk.end); ++v) {
      for (int u = 0; u < scene.width; ++u) {
        const double z = trace(body, frame.camera.intrinsics.unproject(u, v, 1));
        frame.depth.at(u, v) = static_cast<float>(z);
        frame.labels.at(u, v) = z < kWall ? 1 : 0;
      }
    }
  });
  Random random(scene.seed);
  for (float& z : frame.depth.values()) {
    z += static_cast<float>(scene.noise * kSensorNoise.sigma(z) * random.normal());
  }
  if (scene.cover) {
    for (int v = scene.cover->v0; v < scene.cover->v1; ++v) {
      for (int u = scene.cover->u0; u < scene.cover->u1; ++u) {
        frame.depth.at(u, v) = 1;
        frame.labels.at(u, v) = 2;
      }
    }
  }
  if (scene.hole) {
    for (int v = scene.hole->v0; v < scene.hole->v1; ++v) {
      std::fill_n(frame.depth.pixel(scene.hole->u0, v), scene.hole->u1 - scene.hole->u0, 0.0F);
    }
  }
  frame.clean_depth = frame.depth;
  return frame;
}

BodyState standing(double degrees, double height) {
  BodyState state{rest_pose(), Shape::Zero()};
  state.shape[kHeight] = std::log(height / kMeanHeight);
  const double yaw = degrees * std::numbers::pi / 180;
  const Vec up(0, -1, 0);
  const Vec forward(std::sin(yaw), 0, -std::cos(yaw));
  state.pose.root.linear() << up.cross(forward), up, forward;
  state.pose.root.translation() = Vec(0, 0, 2.3);
  return state;
}

double joint_distance(const BodyState& a, const BodyState& b, Joint joint) {
  return (forward_kinematics(a.pose, a.shape)[joint].translation() -
          forward_kinematics(b.pose, b.shape)[joint].translation())
      .norm();
}

double mean_joint_distance(const BodyState& a, const BodyState& b) {
  double sum = 0;
  for (int j = 0; j < kJoints; ++j) sum += joint_distance(a, b, static_cast<Joint>(j));
  return sum / static_cast<double>(kJoints);
}

} // namespace kinora::tracking::testing
