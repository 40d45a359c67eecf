#include "tracking/body/dressed_person.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace kinora::tracking::testing {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kSkirtLength = 0.55; // metres
constexpr double kWaistRadius = 0.15;
constexpr double kHemRadius = 0.32;
constexpr double kSkirtWidth = 1.15; // across over along
constexpr double kCloth = 0.004;     // half the thickness
constexpr double kFolds = 9;         // of the hem
constexpr double kFoldDepth = 0.012;

// Values in [0, 1] on a grid of unit cells, trilinear between.
double value_noise(const Vec& at, std::uint64_t seed) {
  const Vec floor = at.array().floor();
  const Vec share = at - floor;
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::uint64_t key = seed;
    for (int axis = 0; axis < 3; ++axis) {
      const int up = (corner >> axis) & 1;
      weight *= up == 1 ? share[axis] : 1 - share[axis];
      key = mix64(key ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(floor[axis]) + up));
    }
    sum += weight * Random(key).uniform_double();
  }
  return sum;
}

bool is_skin(std::size_t part) {
  if (part == kBodyParts) return false;
  const Joint bone = body_parts()[part].bone;
  return bone == kHead || bone == kNeck || bone == kLeftWrist || bone == kRightWrist;
}

// Metres by which cloth stands off the body.
double cloth_at(std::size_t part, const Vec& local) {
  if (is_skin(part)) return 0.003 * value_noise(local / 0.03, part);
  const bool is_trunk = body_parts()[part].bone < kNeck;
  return (is_trunk ? 0.012 : 0.004) + (is_trunk ? 0.02 : 0.012) * value_noise(local / 0.06, 100 + part);
}

double skirt_radius(double along, double angle) {
  return kWaistRadius + along * (kHemRadius - kWaistRadius) + along * kFoldDepth * std::cos(kFolds * angle);
}

SE3 upright(const SE3& pelvis) {
  const Vec up(0, -1, 0);
  const Vec left = (pelvis.linear().col(0) - pelvis.linear().col(0).dot(up) * up).normalized();
  SE3 waist = SE3::Identity();
  waist.linear() << left, up, left.cross(up);
  waist.translation() = pelvis * Vec(0, 0.10, 0.015);
  return waist;
}

BodyState standing_with(double height, const Shape& shape) {
  BodyState state{rest_pose(), shape};
  state.shape[kHeight] = std::log(height / kMeanHeight);
  state.pose.root.linear() << Vec::UnitX(), -Vec::UnitY(), -Vec::UnitZ();
  state.pose.root.translation() = Vec(0, -0.06, 2.4);
  return state;
}

} // namespace

DressedPerson::DressedPerson(const BodyState& state, const std::optional<Skirt>& skirt)
    : body_(state), skirt_(skirt), waist_(upright(body_.body().bones[kPelvis])) {}

DressedPerson::Sample DressedPerson::sample(std::size_t part, const Vec& position) const {
  constexpr double kThickest = 0.035; // metres
  const PartShape& shape = body_.body().parts[part];
  const ClosestSurface surface = closest_surface(shape, body_.to_bone(part) * position);
  const double cloth = surface.distance < 2 * kThickest ? cloth_at(part, position_of(shape, surface.point)) : kThickest;
  return {surface.distance - cloth, {part, surface.point}, body_.bone(part).linear() * surface.normal};
}

DressedPerson::Sample DressedPerson::sample_skirt(const Vec& position) const {
  const Vec local = waist_.inverse() * position;
  const double along = -local.y() / kSkirtLength;
  const double share = std::clamp(along, 0.0, 1.0);
  const Eigen::Vector2d centre = share * share * skirt_->swing;
  const Eigen::Vector2d across((local.x() - centre.x()) / kSkirtWidth, local.z() - centre.y());
  const double angle = std::atan2(across.x(), across.y()) - share * skirt_->twist;
  const double off = across.norm() - skirt_radius(share, angle);
  const double beyond = kSkirtLength * std::max(along - 1, -along);
  const Vec outward(across.x(), (kHemRadius - kWaistRadius) / kSkirtLength * across.norm(), across.y());
  const Vec normal = waist_.linear() * outward.normalized();
  return {std::max(0.9 * std::abs(off) - kCloth, beyond),
          {kBodyParts, {share, Vec(angle, 0, 0)}},
          off > 0 ? normal : Vec(-normal)};
}

std::optional<DressedPerson::Hit> DressedPerson::trace(const Vec& ray) const {
  constexpr double kMargin = 0.05; // metres, for cloth
  std::optional<Hit> hit;
  const auto march = [&](const Vec& centre, double reach, const auto& surface) {
    const double nearest = centre.dot(ray) / ray.squaredNorm();
    const double passes = (nearest * ray - centre).squaredNorm();
    if (passes > reach * reach) return;
    const double half = std::sqrt(reach * reach - passes) / ray.norm();
    const double end = hit ? std::min(hit->z, nearest + half) : nearest + half;
    for (double z = nearest - half; z < end;) {
      const Sample found = surface(z * ray);
      if (found.distance < 1e-3) {
        hit = Hit{z, found.point, found.normal};
        return;
      }
      z += 0.8 * found.distance / ray.norm();
    }
  };
  for (std::size_t part = 0; part < kBodyParts; ++part) {
    const PartShape& shape = body_.body().parts[part];
    march(body_.bone(part) * shape.centre, shape.reach + kMargin, [&](const Vec& p) { return sample(part, p); });
  }
  if (skirt_) {
    march(waist_ * Vec(0, -kSkirtLength / 2, 0), kSkirtLength / 2 + 1.5 * kHemRadius,
          [&](const Vec& p) { return sample_skirt(p); });
  }
  return hit;
}

Vec DressedPerson::coat_position(const CoatPoint& point) const {
  if (point.part == kBodyParts) {
    const double share = point.of_part.along;
    const double angle = point.of_part.direction.x();
    const double rotated = angle + share * skirt_->twist;
    const double radius = skirt_radius(share, angle) + kCloth;
    const Eigen::Vector2d centre = share * share * skirt_->swing;
    return waist_ * Vec(centre.x() + kSkirtWidth * radius * std::sin(rotated), -share * kSkirtLength,
                        centre.y() + radius * std::cos(rotated));
  }
  const PartShape& shape = body_.body().parts[point.part];
  const Vec local = position_of(shape, point.of_part);
  return body_.bone(point.part) * Vec(local + cloth_at(point.part, local) * normal_of(shape, point.of_part));
}

Vec DressedPerson::colour_of(const CoatPoint& point) {
  if (is_skin(point.part)) {
    const Vec at = Vec(9 * point.of_part.along, 0, 0) + 3 * point.of_part.direction;
    return (0.9 + 0.2 * value_noise(at, 7)) * Vec(0.62, 0.42, 0.32);
  }
  // Solid patterns in units of about a centimetre, unlike each other on every part.
  Vec at = Vec(20 * point.of_part.along, 0, 0) + 7 * point.of_part.direction;
  if (point.part == kBodyParts) {
    const double angle = point.of_part.direction.x();
    at = Vec(40 * point.of_part.along, 20 * std::sin(angle), 20 * std::cos(angle));
  }
  const double pattern = 0.5 * value_noise(at / 4, 200 + point.part) + 0.5 * value_noise(at, 300 + point.part);
  const bool is_below = point.part == kBodyParts || body_parts()[point.part].bone >= kLeftHip;
  return (0.1 + 0.9 * pattern) * (is_below ? Vec(0.35, 0.40, 0.60) : Vec(0.70, 0.45, 0.35));
}

BodyState tall_person() {
  Shape shape = Shape::Zero();
  shape[kUpperArmLength] = 0.05;
  shape[kForearmLength] = 0.06;
  shape[kWaistGirth] = 0.22;
  shape[kChestGirth] = 0.10;
  shape[kThighGirth] = 0.08;
  shape[kTrunkLength] = -0.04;
  return standing_with(1.86, shape);
}

BodyState short_person() {
  Shape shape = Shape::Zero();
  shape[kTrunkLength] = 0.05;
  shape[kThighLength] = -0.05;
  shape[kShoulderWidth] = -0.08;
  shape[kWaistGirth] = -0.10;
  shape[kUpperArmGirth] = -0.10;
  shape[kHipWidth] = 0.06;
  return standing_with(1.57, shape);
}

} // namespace kinora::tracking::testing
