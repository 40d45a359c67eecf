// The three samples: other people, clothes, things, motion, light and sensors than carry_box has.
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "scene.h"

namespace kinora::simulator {
namespace {

using Vec = Eigen::Vector3d;
using Colour = std::function<Vec(const Vec&)>;

/// A value in [0, 1) of each cell of a grid.
double cell_noise(const Vec& at, std::uint64_t seed) {
  std::uint64_t key = seed;
  for (int axis = 0; axis < 3; ++axis)
    key = mix64(key ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(at[axis]))));
  return Random(key).uniform_double();
}

Vec stripes(const Vec& p, double width, const Vec& a, const Vec& b) {
  return std::sin(2 * std::numbers::pi * p.y() / width) > 0.2 ? a : b;
}

Vec checks(const Vec& p, double width, const Vec& a, const Vec& b) {
  const double along = std::sin(2 * std::numbers::pi * p.x() / width);
  const double down = std::sin(2 * std::numbers::pi * p.y() / width);
  return a + (0.25 * (along > 0) + 0.25 * (down > 0) + 0.5 * (along > 0.9 || down > 0.9)) * (b - a);
}

Vec speckled(const Vec& p, double size, std::uint64_t seed, const Vec& colour) {
  return (0.75 + 0.4 * cell_noise(p / size, seed)) * colour;
}

/// Skin that is a little uneven, eyes, hair in strands; the clothes are the scene's.
Vec body_colour(Part part, const Vec& p, const Vec& skin, const Vec& hair) {
  if (part == Part::kEye) return {0.15, 0.12, 0.11};
  if (part == Part::kHair) return (0.7 + 0.6 * cell_noise({p.x() / 0.006, p.y() / 0.06, p.z() / 0.006}, 4)) * hair;
  const double flush = 0.06 * std::sin(45 * p.x() + 3) * std::sin(38 * p.y()) * std::sin(30 * p.z());
  return (1 + flush) * skin;
}

Thing room_part(const Mesh& mesh, Colour colour) {
  return {0, mesh, std::move(colour), [](double, const Human&, const HumanPose&) { return SE3::Identity(); }, false};
}

/// Floor and back wall, `depth` metres behind the origin.
std::vector<Thing> room(double depth, const Vec& floor, const Vec& wall) {
  const auto planks = [floor](const Vec& p) -> Vec {
    const double plank = std::floor(p.x() / 0.14);
    const double grain = cell_noise({p.x() / 0.01, 0, p.z() / 0.09}, 7);
    return (0.75 + 0.25 * cell_noise({plank, 0, std::floor(p.z() / 0.9 + plank * 0.37)}, 9) + 0.12 * grain) * floor;
  };
  const auto paper = [wall](const Vec& p) -> Vec {
    const double bloom =
        std::sin(17 * p.x() + 2 * std::sin(9 * p.y())) * std::sin(15 * p.y() + 2 * std::sin(8 * p.x()));
    return (0.85 + 0.2 * bloom + 0.08 * cell_noise(p / 0.03, 5)) * wall;
  };
  return {room_part(plane({-8, 0, -depth}, {16, 0, 0}, {0, 0, depth + 4}, 80), planks),
          room_part(plane({-8, 0, -depth}, {16, 0, 0}, {0, 3.5, 0}, 80), paper)};
}

SE3 pose_of(const Vec& at, const Eigen::Quaterniond& rotation) {
  SE3 pose = SE3::Identity();
  pose.linear() = rotation.toRotationMatrix();
  pose.translation() = at;
  return pose;
}

Eigen::Quaterniond turned(double degrees, const Vec& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()));
}

/// A glazed pitcher with a painted band.
Vec pitcher_colour(const Vec& p) {
  const double around = std::atan2(p.z(), p.x());
  if (std::abs(p.y()) < 0.045) {
    const bool leaf = std::sin(7 * around + 40 * p.y()) * std::sin(60 * p.y()) > 0.25;
    return leaf ? Vec(0.08, 0.22, 0.12) : Vec(0.78, 0.74, 0.62);
  }
  return speckled(p, 0.008, 31, around > 0 ? Vec(0.14, 0.30, 0.48) : Vec(0.20, 0.36, 0.50));
}

/// By its handle: before the palm, as the hand goes.
SE3 held_in_right_hand(double /*seconds*/, const Human& human, const HumanPose& person) {
  const std::size_t hand = human.bone("RightHand");
  const Vec palm = human.rest_joint(human.bone("RightFingerBase"));
  return person.bones[hand] * pose_of(palm + Vec(-0.01, -0.02, 0.10), turned(-35, Vec::UnitZ()));
}

Scene walk_pitcher(const std::filesystem::path& data) {
  const auto outfit = [](Part part, const Vec& p) -> Vec {
    switch (part) {
    case Part::kShirt:
      return stripes(p, 0.055, {0.70, 0.66, 0.58}, {0.42, 0.08, 0.10});
    case Part::kTrousers:
      return speckled(p, 0.01, 3, {0.30, 0.28, 0.12});
    case Part::kSkirt:
      return checks(p, 0.10, {0.28, 0.30, 0.12}, {0.62, 0.52, 0.20});
    case Part::kShoes:
      return {0.10, 0.06, 0.05};
    default:
      return body_colour(part, p, {0.50, 0.31, 0.22}, {0.10, 0.05, 0.03});
    }
  };
  std::vector<Thing> things = room(1.1, {0.40, 0.26, 0.16}, {0.46, 0.50, 0.44});
  things.push_back({2,
                    lathe({{-0.11, 0},
                           {-0.11, 0.05},
                           {-0.07, 0.075},
                           {-0.02, 0.08},
                           {0.04, 0.06},
                           {0.08, 0.04},
                           {0.11, 0.055},
                           {0.105, 0.045},
                           {0.0, 0.04}}),
                    pitcher_colour, held_in_right_hand});
  return Scene(data, {"walk_pitcher",
                      "cmu_05_01.bvh.gz",
                      5.0,
                      1.0,
                      0,
                      30,
                      {{{"caucasian-female-young", 1.0}, {"universal-female-young-averagemuscle-averageweight", 1.0}},
                       false,
                       true,
                       0.26},
                      outfit,
                      std::move(things),
                      {{-1.8, 2.4, 2.2}, {1.0, 0.86, 0.66}, {0.26, 0.25, 0.27}},
                      {1.0, 0.075, 0.125, 0.45, 0.20, 4, 4.2, 1.2, 0, 0, 92},
                      camera_at({0, 1.3, 2.5}, {0, 0.92, 0})});
}

Scene leap_ball(const std::filesystem::path& data) {
  const auto outfit = [](Part part, const Vec& p) -> Vec {
    switch (part) {
    case Part::kShirt:
      return p.y() > 0.42 || std::abs(p.x()) > 0.2 ? Vec(0.10, 0.30, 0.52)
                                                   : checks(p, 0.07, {0.55, 0.56, 0.58}, {0.12, 0.16, 0.36});
    case Part::kTrousers:
      return speckled(p, 0.006, 8,
                      std::abs(std::abs(p.x()) - 0.17) < 0.02 ? Vec(0.6, 0.6, 0.6) : Vec(0.07, 0.08, 0.10));
    case Part::kShoes:
      return {0.55, 0.20, 0.10};
    default:
      return body_colour(part, p, {0.22, 0.12, 0.08}, {0.03, 0.02, 0.02});
    }
  };
  std::vector<Thing> things = room(1.5, {0.32, 0.34, 0.36}, {0.52, 0.46, 0.36});
  constexpr double kRadius = 0.12;
  things.push_back({2, ball(kRadius),
                    [](const Vec& p) -> Vec {
                      const double around = std::atan2(p.z(), p.x());
                      const int patch =
                          static_cast<int>(std::floor(3 * around / std::numbers::pi)) + (p.y() > 0 ? 1 : 0);
                      return speckled(p, 0.01, 2, patch % 2 == 0 ? Vec(0.70, 0.62, 0.12) : Vec(0.60, 0.16, 0.10));
                    },
                    [](double seconds, const Human&, const HumanPose&) { // it rolls past, then bounces off the floor
                      const double x = -0.95 + 0.75 * seconds;
                      const double fall = std::fmod(seconds + 0.1, 0.5) - 0.25;
                      const double y = kRadius + 0.5 * 9.81 * (0.0625 - fall * fall);
                      return pose_of({x, y, 0.55}, turned(-280 * seconds, Vec(0.1, 0.2, 1)) * turned(40, Vec(1, 1, 0)));
                    }});
  return Scene(
      data, {"leap_ball",
             "cmu_49_04.bvh.gz",
             6.0,
             0.8,
             -10,
             30,
             {{{"african-male-young", 1.0}, {"universal-male-young-averagemuscle-averageweight", 1.0}}, false, false},
             outfit,
             std::move(things),
             {{1.6, 3.2, 1.6}, {0.86, 0.92, 1.05}, {0.20, 0.21, 0.24}},
             {1.3, 0.05, 0, 0.30, 0.45, 2, 4.6, 1.5, 0, 0.012, 88},
             camera_at({0.2, 1.25, 3.0}, {0, 1.0, 0})});
}

Scene guard_crate(const std::filesystem::path& data) {
  const auto outfit = [](Part part, const Vec& p) -> Vec {
    switch (part) {
    case Part::kShirt:
      return checks(p, 0.12, {0.20, 0.32, 0.22}, {0.66, 0.60, 0.50});
    case Part::kTrousers:
      return speckled(p, 0.012, 6, {0.12, 0.17, 0.28});
    case Part::kShoes:
      return {0.24, 0.22, 0.20};
    default:
      return body_colour(part, p, {0.56, 0.38, 0.28}, {0.32, 0.22, 0.10});
    }
  };
  std::vector<Thing> things = room(1.0, {0.28, 0.20, 0.16}, {0.40, 0.40, 0.48});
  const auto wood = [](const Vec& p) -> Vec {
    const bool gap = std::abs(std::fmod(std::abs(p.y() + 0.3), 0.07) - 0.035) < 0.005;
    return gap ? Vec(0.08, 0.05, 0.03) : speckled({p.x() / 3, p.y(), p.z() / 3}, 0.012, 12, {0.52, 0.36, 0.18});
  };
  things.push_back({2, box({0.2, 0.24, 0.2}), wood,
                    [](double, const Human&, const HumanPose&) {
                      return pose_of({0.85, 0.24, 0.1}, turned(25, Vec::UnitY()));
                    },
                    false});
  return Scene(data,
               {"guard_crate",
                "cmu_102_01cc.bvh.gz",
                0.1,
                0.9,
                -65,
                30,
                {{{"asian-male-young", 1.0}, {"universal-male-young-averagemuscle-averageweight", 1.0}}, true, false},
                outfit,
                std::move(things),
                {{0.6, 2.8, 2.8}, {0.50, 0.47, 0.42}, {0.16, 0.16, 0.17}},
                {0.8, 0.06, 0, 0.60, 0.10, 6, 3.6, 2.2, 0.18, 0.005, 90},
                camera_at({-0.1, 1.4, 2.6}, {0, 0.9, 0})});
}

} // namespace

std::vector<std::function<Scene(const std::filesystem::path&)>> sample_scenes() {
  return {walk_pitcher, leap_ball, guard_crate};
}

} // namespace kinora::simulator
