// What dressed people do in front of a camera: motions that lose a tracker.
#pragma once

#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "tracking/body/dressed_person.h"

namespace kinora::tracking::testing {

constexpr double kSceneRate = 30; ///< frames a second

struct PersonScene {
  std::string_view name;
  int frames;
  std::function<DressedPerson(double)> at; ///< the person at a frame, or between two
  std::vector<std::size_t> fast_parts;     ///< whose points are judged by themselves as well (CoatPoint::part)
  bool has_skirt = false;
  double exposure = 0; ///< of the colour camera, in frames
};

/// turn: 400° at 8° a frame. hands: a wide wave and punches, both up to 25 cm a frame. clap: hands touch and part.
/// skirt: hips turn and go to and fro, a skirt follows late. blur: a wave of 18 cm a frame, half a frame exposed.
std::span<const PersonScene> person_scenes();
/// Throws Error(kUsage) if there is none of this name.
const PersonScene& person_scene(std::string_view name);

} // namespace kinora::tracking::testing
