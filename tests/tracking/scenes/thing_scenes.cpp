#include "thing_scenes.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"
#include "tracking/body/dressed_person.h"
#include "tracking/body/limb_poses.h"

namespace kinora::tracking::testing {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kRadians = kPi / 180;

// A person whose arms were put somewhere; the poses of arms are worth being kept.
BodyState with_hands(const Vec& left, const Vec& right, double rotated = 0) {
  BodyState state = tall_person();
  const LimbPose left_pose = reaching(kLeftArm, state, left);
  const LimbPose right_pose = reaching(kRightArm, state, right);
  set_limb(kLeftArm, left_pose, left_pose, 0, state);
  set_limb(kRightArm, right_pose, right_pose, 0, state);
  rotate_root(state, rotated);
  return state;
}

BodyState between(const BodyState& a, const BodyState& b, double share) {
  BodyState state = a;
  state.pose.angles += share * (b.pose.angles - a.pose.angles);
  state.pose.root.linear() = Eigen::Quaterniond(a.pose.root.linear())
                                 .slerp(share, Eigen::Quaterniond(b.pose.root.linear()))
                                 .toRotationMatrix();
  state.pose.root.translation() += share * (b.pose.root.translation() - a.pose.root.translation());
  return state;
}

SE3 pose_of(const Vec& at, const Eigen::Matrix3d& rotation) {
  SE3 pose = SE3::Identity();
  pose.linear() = rotation;
  pose.translation() = at;
  return pose;
}

Eigen::Matrix3d rotated(double degrees, const Vec& axis) {
  return Eigen::AngleAxisd(degrees * kRadians, axis.normalized()).toRotationMatrix();
}

Eigen::Matrix3d upright() { return rotated(180, Vec::UnitX()); } // things have y up

Vec wrist_of(const BodyState& state, Joint wrist, const Vec& beyond) {
  return pose_body(state.pose, state.shape).bones[wrist] * beyond;
}

ThingScene spinning_vase(std::string_view name, bool printed, double speed) {
  const BodyState still = with_hands({0.15, -0.10, 0.26}, {-0.13, -0.03, 0.30});
  const auto person = [still](double frame) {
    BodyState state = still;
    rotate_root(state, 6 * std::sin(frame / 14));
    return state;
  };
  const auto pose = [speed](double frame) {
    const Vec centre(0.03 * std::sin(frame / 12), -0.33 + 0.02 * std::sin(frame / 9), 2.02);
    const Eigen::Matrix3d tilt = rotated(14, {1, 0, 0.4}) * upright();
    return pose_of(centre, tilt * rotated(40 + speed * frame, Vec::UnitY()));
  };
  return {name, 90, person, {{vase(printed), 2, pose}}};
}

// The right hand takes it from before the body to its side and behind the back, and out again.
ThingScene swung_mallet() {
  const std::array<BodyState, 3> stations = {with_hands({0.35, -0.30, 0.08}, {-0.20, 0.05, 0.35}),
                                             with_hands({0.35, -0.30, 0.08}, {-0.42, -0.12, 0.02}),
                                             with_hands({0.35, -0.30, 0.08}, {-0.16, -0.22, -0.22})};
  const auto person = [stations](double frame) {
    const double way = 2 * stroke(frame, 15, 18, 12);
    return way < 1 ? between(stations[0], stations[1], way) : between(stations[1], stations[2], way - 1);
  };
  const auto pose = [person](double frame) {
    const double way = stroke(frame, 15, 18, 12);
    const Vec hand = wrist_of(person(frame), kRightWrist, {-0.07, 0, 0});
    const Eigen::Matrix3d rotation =
        rotated(-20 + 75 * way, Vec::UnitZ()) * rotated(25 * std::sin(frame / 7), Vec::UnitY()) * upright();
    return pose_of(hand - rotation * Vec(0, -0.17, 0), rotation);
  };
  return {"mallet", 80, person, {{mallet(), 2, pose}}};
}

ThingScene thrown_ball(std::string_view name, bool striped) {
  const BodyState low = with_hands({0.35, -0.20, 0.20}, {-0.35, -0.10, 0.30}, 15);
  const BodyState high = with_hands({0.30, 0.05, 0.30}, {-0.28, 0.15, 0.40}, -15);
  constexpr double kThrown = 20; // frame
  constexpr double kRadius = 0.09;
  const auto person = [low, high](double frame) { return between(low, high, eased(frame, 10, 12)); };
  const auto contact = [person](double frame) -> Vec {
    return wrist_of(person(frame), kRightWrist, {-0.08, 0, 0}) + Vec(0, -0.07, -0.05);
  };
  const auto pose = [contact](double frame) {
    constexpr double kFall = 9.81 / 900 / 2; // metres a frame², y down
    constexpr double kFlight = 13;           // frames; then it is caught at the other side and lies there
    const double flown = std::clamp(frame - kThrown, 0.0, kFlight);
    const Vec centre =
        frame <= kThrown
            ? contact(frame)
            : Vec(contact(kThrown) + flown * Vec(0.092, -0.062, -0.006) + kFall * flown * flown * Vec::UnitY());
    return pose_of(centre, rotated(8 * flown, {0.3, 0.2, 1}) * rotated(20, {1, 0.5, 0}));
  };
  return {name, 50, person, {{ball(kRadius, striped), 2, pose}}, 0.5};
}

const Vec kTableHalf(0.42, 0.02, 0.22);
const Vec kTable(0, 0.28, 1.85);

MovingThing table() {
  return {plain_box(kTableHalf, {0.45, 0.42, 0.38}), 0,
          [](double) { return pose_of(kTable, Eigen::Matrix3d::Identity()); }};
}

SE3 on_table(double x, double z, double half_height, double degrees) {
  return pose_of({x, kTable.y() - kTableHalf.y() - half_height, z}, upright() * rotated(degrees, Vec::UnitY()));
}

SE3 mixed(const SE3& a, const SE3& b, double share) {
  return pose_of(a.translation() + share * (b.translation() - a.translation()),
                 Eigen::Quaterniond(a.linear()).slerp(share, Eigen::Quaterniond(b.linear())).toRotationMatrix());
}

// Hands go where things are: in the chest's axes a thing at (x, y, z) of the world.
BodyState hands_at(const Vec& left, const Vec& right) {
  const BodyState state = tall_person();
  const SE3 to_chest = pose_body(state.pose, state.shape).bones[kChest].inverse();
  return with_hands(to_chest * left, to_chest * right);
}

ThingScene two_in_turn() {
  const Vec half_a(0.08, 0.06, 0.05);
  const Vec half_b(0.05, 0.10, 0.04);
  const SE3 held_a = pose_of({0.02, -0.12, 1.95}, rotated(15, {1, 0, 0}) * upright());
  const SE3 down_a = on_table(0.05, 1.95, half_a.y(), 25);
  const SE3 down_b = on_table(-0.02, 1.74, half_b.y(), -20);
  const SE3 held_b = pose_of({-0.08, -0.15, 1.85}, rotated(-20, {1, 0, 0.2}) * upright());
  const auto pose_a = [=](double frame) {
    const SE3 turning = held_a * pose_of(Vec::Zero(), rotated(40 * std::sin(frame / 10), Vec::UnitY()));
    return mixed(turning, down_a, eased(frame, 25, 15));
  };
  const auto pose_b = [=](double frame) {
    const SE3 up = mixed(down_b, held_b, eased(frame, 50, 12));
    return up * pose_of(Vec::Zero(), rotated(60 * eased(frame, 62, 25), {0.2, 1, 0}));
  };
  const auto person = [=](double frame) {
    const Vec at_a = pose_a(frame).translation();
    const Vec at_b = pose_b(frame).translation();
    const Vec at = at_a + eased(frame, 41, 8) * (at_b - at_a);
    return hands_at(at + Vec(0.15, 0.0, 0.06), at + Vec(-0.15, 0.0, 0.06));
  };
  return {"two", 90, person, {{printed_box(half_a, 21), 2, pose_a}, {printed_box(half_b, 37), 3, pose_b}, table()}};
}

ThingScene swapped() {
  const Vec half(0.06, 0.08, 0.05);
  const auto pose = [half](double side, double frame) {
    const double way = eased(frame, 20, 30);
    const double angle = kPi * way;
    const Vec centre(0.20 * side * std::cos(angle), -0.10, 1.90 - 0.11 * side * std::sin(angle));
    return pose_of(centre, upright() * rotated(20 * side + 30 * side * way, Vec::UnitY()));
  };
  const auto person = [pose](double frame) {
    const Vec first = pose(1, frame).translation();
    const Vec second = pose(-1, frame).translation();
    return hands_at((frame < 35 ? first : second) + Vec(0.04, 0.10, 0.05),
                    (frame < 35 ? second : first) + Vec(-0.04, 0.10, 0.05));
  };
  return {"swap",
          70,
          person,
          {{printed_box(half, 5), 2, [pose](double frame) { return pose(1, frame); }},
           {printed_box(half, 6), 3, [pose](double frame) { return pose(-1, frame); }}}};
}

ThingScene hand_held() {
  const auto pose = [](double frame) {
    return pose_of({0.05 * std::sin(frame / 15), -0.18, 1.95},
                   rotated(20, {1, 0, 0}) * upright() * rotated(50 * std::sin(frame / 16), Vec::UnitY()));
  };
  const auto person = [pose](double frame) {
    const Vec at = pose(frame).translation();
    return hands_at(at + Vec(0.15, 0.02, 0.04), at + Vec(-0.15, 0.02, 0.04));
  };
  const auto camera = [](double frame) {
    const Vec away(0.06 * std::sin(frame / 17), 0.02 * std::sin(frame / 6), 0.05 * (1 - std::cos(frame / 23)));
    const Vec axis(2 * std::sin(frame / 13), 4 * std::sin(frame / 19), 1.5 * std::sin(frame / 8));
    return pose_of(away,
                   Eigen::AngleAxisd(axis.norm() * kRadians, axis.norm() > 0 ? Vec(axis.normalized()) : Vec::UnitX())
                       .toRotationMatrix());
  };
  return {"hand_held", 90, person, {{printed_box({0.09, 0.07, 0.05}, 8), 2, pose}}, 0, camera};
}

} // namespace

std::span<const ThingScene> thing_scenes() {
  static const std::array<ThingScene, 10> scenes = {spinning_vase("vase_slow", false, 3),
                                                    spinning_vase("vase_fast", false, 10),
                                                    spinning_vase("vase_printed", true, 3),
                                                    spinning_vase("vase_printed_fast", true, 10),
                                                    swung_mallet(),
                                                    thrown_ball("ball_plain", false),
                                                    thrown_ball("ball_striped", true),
                                                    two_in_turn(),
                                                    swapped(),
                                                    hand_held()};
  return scenes;
}

const ThingScene& thing_scene(std::string_view name) {
  for (const ThingScene& scene : thing_scenes()) {
    if (scene.name == name) return scene;
  }
  throw Error(ErrorCode::kUsage, "there is no scene of the name " + std::string(name));
}

} // namespace kinora::tracking::testing
