#include "loop_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace kinora::tracking::testing {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

/// What a seed chooses.
struct Choice {
  double bow;    ///< of the depth: 10 to 17° in a turn
  double radius; ///< of the circle, metres
  double speed;  ///< degrees a frame
  double sway;   ///< phase of a hand's sway, radians
};

Choice choose(std::uint64_t seed) {
  Random random(seed, 17);
  Choice choice{};
  choice.bow = (seed % 2 == 0 ? 1 : -1) * (0.015 + 0.01 * random.uniform_double());
  choice.radius = 0.2 + 0.3 * random.uniform_double();
  choice.speed = 3 + 1.5 * random.uniform_double();
  choice.sway = 6 * random.uniform_double();
  return choice;
}

// Looks outwards at `degrees` of the circle about (0, 0, 0.3), carried by a hand.
SE3 on_circle(double degrees, const Choice& choice) {
  const double a = degrees * kRadians;
  const Eigen::Vector3d position(choice.radius * std::sin(a), 0.04 * std::sin(3 * a + choice.sway),
                                 0.3 + choice.radius * std::cos(a));
  return pose_at(position, 3 * std::sin(2 * a + choice.sway), degrees, 3 * std::sin(2.5 * a));
}

void add(LoopScene& scene, const SE3& pose, const RoomOptions& options) {
  scene.truth.push_back(pose);
  scene.options.push_back(options);
}

RoomOptions room_of(std::uint64_t seed, const Choice& choice) {
  RoomOptions options;
  options.bow = choice.bow;
  options.seed = seed;
  return options;
}

} // namespace

LoopScene rotate_around(std::uint64_t seed) {
  const Choice choice = choose(seed);
  LoopScene scene{"turn_around", {}, {}};
  for (double degrees = 0, speed = 0; degrees < 400; degrees += speed) {
    add(scene, on_circle(degrees, choice), room_of(seed, choice));
    speed = std::min(choice.speed, speed + 0.4);
  }
  return scene;
}

LoopScene rotate_with_hard_stretches(std::uint64_t seed) {
  const Choice choice = choose(seed);
  LoopScene scene{"hard_stretches", {}, {}};
  for (double degrees = 0, speed = 0; degrees < 400; degrees += speed) {
    RoomOptions options = room_of(seed, choice);
    const double from = 40 * static_cast<double>(seed % 3);
    if (degrees >= 90 + from && degrees < 105 + from) options.light = 0.004;
    if (degrees >= 220 && degrees < 228) options.only_wall = true;
    const bool fast = degrees >= 270 && degrees < 310;
    add(scene, on_circle(degrees, choice), options);
    speed = std::clamp(fast ? 7.0 : choice.speed, speed - 1, speed + 1);
  }
  return scene;
}

LoopScene covered_on_the_way(std::uint64_t seed) {
  const Choice choice = choose(seed);
  LoopScene scene{"covered", {}, {}};
  RoomOptions options = room_of(seed, choice);
  options.bow = 0;
  double degrees = 0;
  for (double speed = 0; degrees < 180; degrees += speed) {
    add(scene, on_circle(degrees, choice), options);
    speed = std::min(choice.speed, speed + 0.4);
  }
  options.covered = true;
  for (int i = 0; i < 40; ++i) add(scene, on_circle(degrees, choice), options);
  options.covered = false;
  const double back = 30 + 60 * Random(seed, 18).uniform_double();
  Choice elsewhere = choice;
  elsewhere.radius = choice.radius - 0.2;
  for (int i = 0; i < 20; ++i) add(scene, on_circle(back + i, elsewhere), options);
  return scene;
}

LoopScene alike_place(std::uint64_t seed, double periods) {
  Choice choice = choose(seed);
  constexpr double kPeriod = 0.8;
  LoopScene scene{"alike", {}, {}};
  RoomOptions options = room_of(seed, choice);
  options.alike = kPeriod;
  const auto at = [&](double x, double degrees) {
    return pose_at({x, 0.03 * std::sin(choice.sway + 0.05 * degrees), 1.4}, 0, degrees);
  };
  double degrees = 0;
  for (double speed = 0; degrees < 360; degrees += speed) {
    add(scene, at(-0.4 + kPeriod * periods * degrees / 360, degrees), options);
    speed = std::min(choice.speed, speed + 0.4);
  }
  for (int i = 0; i < 12; ++i) add(scene, at(-0.4 + kPeriod * periods, 360 + 2 * i), options);
  return scene;
}

} // namespace kinora::tracking::testing
