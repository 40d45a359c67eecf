// What people do with things in front of a camera: motions that lose a tracker of rigid objects.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "core/se3.h"
#include "ingest/frame/frame.h"
#include "thing.h"
#include "tracking/body/body_evidence.h"

namespace kinora::tracking::testing {

/// A thing and where it is: thing to world, at a frame or between two. Label 0: of the room.
struct MovingThing {
  Thing thing;
  std::uint8_t label;
  std::function<SE3(double)> pose;
};

/// The world is the camera of frame 0. A floor and a wall stand about it.
struct ThingScene {
  std::string_view name;
  int frames;
  std::function<BodyState(double)> person; ///< in the world
  std::vector<MovingThing> things;
  double exposure = 0;                                                        ///< of the colour camera, in frames
  std::function<SE3(double)> camera = [](double) { return SE3::Identity(); }; ///< to the world
};

/// vase_*: held before the chest and spun about its axis by 3 or 10° a frame, glazed or printed. mallet: swung behind
/// the back and out again. ball_*: thrown, 11 cm a frame, half a frame exposed. two: one is set down behind another,
/// which is then taken up. swap: two of one shape change places. hand_held: a box that is turned, before a camera that
/// a hand holds.
std::span<const ThingScene> thing_scenes();
/// Throws Error(kUsage) if there is none of this name.
const ThingScene& thing_scene(std::string_view name);

struct ThingCamera {
  int width = 640;
  int height = 480;
  double focal = 525;
  double range = 2.9; ///< metres: the farthest depth that is measured
  std::uint64_t seed = 1;
};

/// The scene's frame (from 0): person label 1, things as they are labelled, through a sensor with faults.
ingest::Frame see_things(const ThingScene& scene, int frame, const ThingCamera& camera = {});

} // namespace kinora::tracking::testing
