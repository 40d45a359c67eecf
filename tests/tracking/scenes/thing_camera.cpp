// How the scenes of thing_scenes.h are drawn.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "faulty_sensor.h"
#include "ingest/depth/depth_cleaning.h"
#include "thing_scenes.h"
#include "tracking/body/dressed_person.h"

namespace kinora::tracking::testing {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kBlurSteps = 5;
constexpr double kRate = 30;
constexpr double kFloor = 0.97; // metres below the camera of frame 0
constexpr double kWall = 3.6;
const Vec kLight = Vec(-0.4, -0.8, -0.5).normalized(); // towards it

/// Linear light, depth without faults (0: nothing) and labels.
struct Picture {
  Image<float> light;
  DepthImage depth;
  LabelImage labels;
};

struct Instant {
  DressedPerson person;
  SE3 camera_to_world;
  std::vector<SE3> camera_to_thing;
};

Instant at(const ThingScene& scene, double frame) {
  const SE3 camera = scene.camera(frame);
  BodyState state = scene.person(frame);
  state.pose.root = camera.inverse() * state.pose.root;
  Instant instant{DressedPerson(state), camera, {}};
  for (const MovingThing& thing : scene.things) {
    instant.camera_to_thing.push_back(thing.pose(frame).inverse() * camera);
  }
  return instant;
}

// As a factor on the ray, before `end`; negative: it passes.
double trace(const Thing& thing, const SE3& camera_to_thing, const Vec& ray, double end) {
  const Vec eye = camera_to_thing.translation();
  const Vec way = camera_to_thing.linear() * ray;
  const double nearest = -eye.dot(way) / way.squaredNorm();
  const double passes = (eye + nearest * way).squaredNorm();
  if (passes > thing.reach * thing.reach) return -1;
  const double half = std::sqrt(thing.reach * thing.reach - passes) / way.norm();
  for (double z = nearest - half; z < std::min(end, nearest + half);) {
    const double distance = thing.distance(eye + z * way);
    if (distance < 5e-4) return z;
    z += 0.9 * distance / way.norm();
  }
  return -1;
}

// Waves of several lengths: something to see on floor and wall.
Vec room_colour(double a, double b) {
  const double wave = std::sin(9 * a + 3 * std::sin(2 * b)) * std::sin(11 * b + 2 * std::sin(3 * a)) +
                      0.5 * std::sin(31 * a + 5 * b) * std::sin(27 * b - 7 * a);
  return (0.45 + 0.15 * wave) * Vec(0.8, 0.75, 0.65);
}

struct Seen {
  double z = 0;
  std::uint8_t label = 0;
  Vec light = Vec::Zero();
};

Seen see(const ThingScene& scene, const Instant& instant, const Vec& ray) {
  const Eigen::Matrix3d& rotation = instant.camera_to_world.linear();
  const auto lit = [&](const Vec& normal, const Vec& colour) -> Vec {
    return (0.45 + 0.55 * std::max(0.0, normal.dot(kLight))) * colour;
  };
  const Vec eye = instant.camera_to_world.translation();
  const Vec way = rotation * ray;
  const double wall = (kWall - eye.z()) / way.z();
  const double floor = way.y() > 0 ? (kFloor - eye.y()) / way.y() : 2 * wall;
  Seen seen;
  seen.z = std::min(wall, floor);
  const Vec position = eye + seen.z * way;
  seen.light = floor < wall ? lit(-Vec::UnitY(), room_colour(position.x(), position.z()))
                            : lit(-Vec::UnitZ(), room_colour(position.x(), position.y()));
  if (const auto hit = instant.person.trace(ray); hit && hit->z < seen.z) {
    seen = {hit->z, 1, lit(rotation * hit->normal, DressedPerson::colour_of(hit->point))};
  }
  for (std::size_t i = 0; i < scene.things.size(); ++i) {
    const Thing& thing = scene.things[i].thing;
    const SE3& to_thing = instant.camera_to_thing[i];
    const double z = trace(thing, to_thing, ray, seen.z);
    if (z < 0) continue;
    const Vec local = to_thing * Vec(z * ray);
    const Vec normal = rotation * (to_thing.linear().transpose() * thing.normal(local));
    const Vec half_way = (kLight - way.normalized()).normalized();
    const double highlight = thing.gloss * std::pow(std::max(0.0, normal.dot(half_way)), 60);
    seen = {z, scene.things[i].label, lit(normal, thing.colour(local)) + Vec::Constant(highlight)};
  }
  return seen;
}

Picture draw(const ThingScene& scene, double frame, const Intrinsics& intrinsics) {
  const Instant instant = at(scene, frame);
  Picture picture{Image<float>(intrinsics.width, intrinsics.height, 3), DepthImage(intrinsics.width, intrinsics.height),
                  LabelImage(intrinsics.width, intrinsics.height)};
  parallel_for(static_cast<std::size_t>(intrinsics.height), 4, [&](const Chunk& chunk) {
    for (int v = static_cast<int>(chunk.begin); v < static_cast<int>(chunk.end); ++v) {
      for (int u = 0; u < intrinsics.width; ++u) {
        const Seen seen = see(scene, instant, intrinsics.unproject(u, v, 1));
        std::copy_n(seen.light.cast<float>().eval().data(), 3, picture.light.pixel(u, v));
        picture.depth.at(u, v) = static_cast<float>(seen.z);
        picture.labels.at(u, v) = seen.label;
      }
    }
  });
  return picture;
}

} // namespace

ingest::Frame see_things(const ThingScene& scene, int frame, const ThingCamera& camera) {
  ingest::Frame result;
  result.index = frame;
  result.time = frame / kRate;
  result.camera.intrinsics = {
      camera.width, camera.height, camera.focal, camera.focal, (camera.width - 1) / 2.0, (camera.height - 1) / 2.0};
  result.camera.camera_to_world = scene.camera(frame);
  Picture picture = draw(scene, frame, result.camera.intrinsics);
  if (scene.exposure > 0) {
    std::fill(picture.light.values().begin(), picture.light.values().end(), 0.0F);
    for (double i = 0; i < kBlurSteps; ++i) {
      const double moment = frame + scene.exposure * ((i + 0.5) / kBlurSteps - 0.5);
      const Picture step = draw(scene, moment, result.camera.intrinsics);
      for (std::size_t k = 0; k < step.light.values().size(); ++k) {
        picture.light.values()[k] += step.light.values()[k] / static_cast<float>(kBlurSteps);
      }
    }
  }
  Random random(camera.seed, static_cast<std::uint64_t>(frame));
  result.color = exposed(picture.light, random);
  result.labels = std::move(picture.labels);
  result.depth = measured(picture.depth, random);
  for (float& z : result.depth.values()) {
    if (z > static_cast<float>(camera.range)) z = 0;
  }
  result.clean_depth = ingest::clean_depth(result.depth, result.camera.intrinsics);
  return result;
}

} // namespace kinora::tracking::testing
