#include "tracking/body/person_jumps.h"

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "motion/point_track.h"
#include "tracking/body/limb_poses.h"

namespace kinora::tracking::testing {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kMaxShift = 0.30;
constexpr double kMaxRotation = 40 * std::numbers::pi / 180;

double between(double least, double most, Random& random) { return least + (most - least) * random.uniform_double(); }

double side_of(Limb arm) { return arm == kLeftArm ? 1 : -1; }

// Beside and before the chest, clear of trunk and head: in the chest's axes, metres.
Vec hand_position(Limb arm, Random& random) {
  return {side_of(arm) * between(0.10, 0.55, random), between(-0.25, 0.40, random), between(0.12, 0.45, random)};
}

// On the way to somewhere that is as far as any size needs; the wrist goes `size` metres, all sizes on the same way.
BodyState with_hand_shifted(Limb arm, const BodyState& state, double size, Random& random) {
  const auto wrist = [&](const BodyState& of) {
    return Vec(forward_kinematics(of.pose, of.shape)[chain_of(arm).end].translation());
  };
  const Vec before = wrist(state);
  const LimbPose start = pose_of(arm, state.pose.angles);
  LimbPose end = start;
  BodyState after = state;
  while ((wrist(after) - before).norm() < kMaxShift) {
    end = reaching(arm, state, hand_position(arm, random));
    set_limb(arm, start, end, 1, after);
  }
  double low = 0;
  double high = 1;
  for (int i = 0; i < 40; ++i) {
    const double share = (low + high) / 2;
    set_limb(arm, start, end, share, after);
    ((wrist(after) - before).norm() < size ? low : high) = share;
  }
  return after;
}

// The elbow bends or stretches, whichever has room for all sizes.
BodyState with_forearm_rotated(Limb arm, BodyState state, double degrees) {
  constexpr double kMaxBending = 2.4; // radians
  double& hinge = state.pose.angles[joints()[chain_of(arm).hinge].first_angle];
  hinge += (hinge + kMaxRotation < kMaxBending ? 1 : -1) * degrees * std::numbers::pi / 180;
  return state;
}

std::vector<std::size_t> moved_parts(Jump jump, Limb arm) {
  std::vector<std::size_t> parts;
  if (jump != Jump::kHandShift && jump != Jump::kForearmRotation) return parts; // all
  for (const std::size_t part : chain_of(arm).parts) {
    if (body_parts()[part].bone != chain_of(arm).ball) parts.push_back(part);
  }
  return parts;
}

} // namespace

std::string_view name_of(Jump jump) {
  switch (jump) {
  case Jump::kPersonShift:
    return "person_shift";
  case Jump::kPersonRotation:
    return "person_turn";
  case Jump::kHandShift:
    return "hand_shift";
  case Jump::kForearmRotation:
    break;
  }
  return "forearm_turn";
}

PersonScene jumping_person(Jump jump, double size, std::uint64_t trial) {
  Random random(trial, 17);
  BodyState before = trial % 2 == 0 ? tall_person() : short_person();
  rotate_root(before, between(-25, 25, random));
  const Limb arm = random.below(2) == 0 ? kLeftArm : kRightArm;
  for (const Limb each : {kLeftArm, kRightArm}) {
    const LimbPose pose = reaching(each, before, hand_position(each, random));
    set_limb(each, pose, pose, 0, before);
  }
  BodyState after = before;
  const double course = 2 * std::numbers::pi * random.uniform_double();
  const double way = random.below(2) == 0 ? 1 : -1;
  if (jump == Jump::kPersonShift) after.pose.root.translation() += size * Vec(std::cos(course), 0, std::sin(course));
  if (jump == Jump::kPersonRotation) rotate_root(after, way * size);
  if (jump == Jump::kHandShift) after = with_hand_shifted(arm, before, size, random);
  if (jump == Jump::kForearmRotation) after = with_forearm_rotated(arm, before, size);
  const auto at = [before, after](double frame) { return DressedPerson(frame < kJumpFrame ? before : after); };
  return {name_of(jump), kJumpFrames, at, moved_parts(jump, arm)};
}

std::vector<double> errors_after_jump(const PersonScene& scene, const motion::Motion& motion, std::size_t frames,
                                      int frame, const PersonCamera& camera, std::size_t points) {
  std::vector<Eigen::Vector3d> starts, ends;
  for (const auto& [id, positions] : track_person(scene, points, camera, scene.fast_parts)) {
    const evaluate::TruePosition& start = positions.at(kJumpFrame - 1);
    const evaluate::TruePosition& end = positions.at(frame);
    if (!start.visible || !end.visible) continue;
    starts.push_back(start.point);
    ends.push_back(end.point);
  }
  const auto tracks = motion::track_points(motion, frames, kJumpFrame - 1, starts);
  std::vector<double> errors;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    errors.push_back((tracks[i][static_cast<std::size_t>(frame)] - ends[i]).norm());
  }
  return errors;
}

} // namespace kinora::tracking::testing
