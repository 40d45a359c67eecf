#include "tracking/body/person_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"
#include "tracking/body/limb_poses.h"

namespace kinora::tracking::testing {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

DressedPerson rotating(double frame) {
  BodyState state = tall_person();
  constexpr double kBegin = 8;
  constexpr double kRamp = 6;
  constexpr double kSpeed = 8; // degrees a frame
  const double since = std::max(0.0, frame - kBegin);
  for (const Limb arm : {kLeftArm, kRightArm}) {
    const double side = arm == kLeftArm ? 1 : -1;
    const LimbPose low = reaching(arm, state, {0.32 * side, -0.28, 0.08});
    const LimbPose high = reaching(arm, state, {0.40 * side, -0.20, 0.12});
    set_limb(arm, low, high, 0.5 - 0.5 * std::cos(2 * kPi * frame / 30), state);
  }
  rotate_root(state, kSpeed * (since < kRamp ? since * since / (2 * kRamp) : since - kRamp / 2));
  return DressedPerson(state);
}

DressedPerson throwing_hands(double frame) {
  BodyState state = tall_person();
  const LimbPose low = reaching(kRightArm, state, {-0.50, 0.08, 0.26});
  const LimbPose high = reaching(kRightArm, state, {0.0, 0.36, 0.40});
  double waved = 0;
  for (const double begin : {12.0, 22.0, 32.0}) waved += stroke(frame, begin, 5, 0);
  set_limb(kRightArm, low, high, waved + stroke(frame, 62, 5, 8), state);
  const LimbPose drawn = reaching(kLeftArm, state, {0.24, -0.02, 0.12});
  const LimbPose stretched = reaching(kLeftArm, state, {0.12, 0.16, 0.56});
  set_limb(kLeftArm, drawn, stretched, stroke(frame, 44, 3, 2) + stroke(frame, 55, 3, 2), state);
  rotate_root(state, 15 + 5 * std::sin(2 * kPi * frame / 40));
  return DressedPerson(state);
}

DressedPerson clapping(double frame) {
  BodyState state = short_person();
  double closed = 0;
  for (const double begin : {10.0, 24.0, 36.0, 46.0}) closed += stroke(frame, begin, 5, begin < 20 ? 3 : 0);
  for (const Limb arm : {kLeftArm, kRightArm}) {
    const double side = arm == kLeftArm ? 1 : -1;
    const LimbPose open = reaching(arm, state, {0.30 * side, 0.02, 0.26});
    const LimbPose shut = reaching(arm, state, {0.085 * side, 0.06, 0.28});
    set_limb(arm, open, shut, closed, state);
  }
  rotate_root(state, -15 + 4 * std::sin(2 * kPi * frame / 50));
  return DressedPerson(state);
}

// Begins with hands that touch.
DressedPerson parting(double frame) {
  BodyState state = short_person();
  const double closed = 1 - stroke(frame, 8, 8, 6) - stroke(frame, 34, 5, 4);
  for (const Limb arm : {kLeftArm, kRightArm}) {
    const double side = arm == kLeftArm ? 1 : -1;
    const LimbPose open = reaching(arm, state, {0.30 * side, 0.02, 0.26});
    const LimbPose shut = reaching(arm, state, {0.085 * side, 0.06, 0.28});
    set_limb(arm, open, shut, closed, state);
  }
  rotate_root(state, -15 + 4 * std::sin(2 * kPi * frame / 50));
  return DressedPerson(state);
}

DressedPerson swaying(double frame) {
  BodyState state = short_person();
  const double phase = 2 * kPi * frame / 28;
  constexpr double kLag = 1.1; // radians that the hem is late
  rotate_root(state, 35 * std::sin(phase));
  state.pose.root.translation().x() += 0.05 * std::sin(phase / 2);
  return DressedPerson(state, Skirt{{0.09 * std::sin(phase / 2 - kLag), 0.03 * std::sin(phase)},
                                    35 * kPi / 180 * (std::sin(phase - kLag) - std::sin(phase))});
}

DressedPerson waving(double frame) {
  BodyState state = tall_person();
  const LimbPose low = reaching(kLeftArm, state, {0.52, 0.10, 0.25});
  const LimbPose high = reaching(kLeftArm, state, {0.22, 0.42, 0.32});
  set_limb(kLeftArm, low, high, 0.5 - 0.5 * std::cos(2 * kPi * std::max(0.0, frame - 8) / 11), state);
  rotate_root(state, -10 + 12 * std::sin(2 * kPi * frame / 45));
  return DressedPerson(state);
}

std::vector<std::size_t> lower_parts(std::initializer_list<Limb> limbs) {
  std::vector<std::size_t> parts;
  for (const Limb limb : limbs) {
    for (const std::size_t part : chain_of(limb).parts) {
      if (body_parts()[part].bone != chain_of(limb).ball) parts.push_back(part);
    }
  }
  return parts;
}

} // namespace

std::span<const PersonScene> person_scenes() {
  static const std::array<PersonScene, 6> scenes = {{
      {"turn", 62, rotating, lower_parts({kLeftArm, kRightArm})},
      {"hands", 85, throwing_hands, lower_parts({kLeftArm, kRightArm})},
      {"clap", 64, clapping, lower_parts({kLeftArm, kRightArm})},
      {"part", 52, parting, lower_parts({kLeftArm, kRightArm})},
      {"skirt", 60, swaying, {kBodyParts}, true},
      {"blur", 50, waving, lower_parts({kLeftArm}), false, 0.5},
  }};
  return scenes;
}

const PersonScene& person_scene(std::string_view name) {
  for (const PersonScene& scene : person_scenes()) {
    if (scene.name == name) return scene;
  }
  throw Error(ErrorCode::kUsage, "there is no scene of the name " + std::string(name));
}

} // namespace kinora::tracking::testing
