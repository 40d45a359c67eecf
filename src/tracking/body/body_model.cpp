#include "tracking/body/body_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kSampleSpacing = 0.035; // metres
constexpr double kHidden = 0.005;        // metres inside another part

std::array<BodyPart, kBodyParts> build_parts() {
  constexpr auto kTrunk = kTrunkLength;
  std::array<BodyPart, kBodyParts> parts = {{
      {kPelvis,
       {0, 0.008, 0.008},
       {0, 0.063, 0.005},
       0.070,
       0.064,
       kTrunk,
       kPelvisGirth,
       kWaistGirth,
       1.40,
       kTrunkWidth},
      {kSpine,
       {0, -0.008, 0.016},
       {0, 0.082, 0.014},
       0.063,
       0.067,
       kTrunk,
       kWaistGirth,
       kChestGirth,
       1.40,
       kTrunkWidth},
      {kChest, {0, 0.045, 0.020}, {0, 0.110, 0.020}, 0.069, 0.060, kTrunk, kChestGirth, kChestGirth, 1.38, kTrunkWidth},
      {kNeck, {0, -0.028, -0.004}, {0, 0.058, 0.012}, 0.036, 0.034, kNeckLength, kNeckGirth, kNeckGirth},
      {kHead, {0, 0.004, 0.014}, {0, 0.040, 0.006}, 0.046, 0.050, kHeadLength, kHeadGirth, kHeadGirth, 0.85, {}, true},
      {kLeftClavicle,
       {0.010, -0.012, 0.005},
       {0.092, -0.020, 0},
       0.042,
       0.036,
       kShoulderWidth,
       kShoulderGirth,
       kShoulderGirth},
      {kLeftShoulder, {0, 0, 0}, {0.162, 0, 0}, 0.033, 0.025, kUpperArmLength, kUpperArmGirth, kUpperArmGirth},
      {kLeftElbow, {0, 0, 0}, {0.146, 0, 0}, 0.027, 0.016, kForearmLength, kForearmGirth, kForearmGirth},
      {kLeftWrist, {0.005, 0, 0}, {0.083, 0, 0}, 0.019, 0.013, kHandLength, kHandGirth, kHandGirth, 1, {}, true},
      {kLeftHip, {0, -0.040, 0.010}, {0, -0.245, 0.005}, 0.053, 0.0345, kThighLength, kThighGirth, kKneeGirth},
      {kLeftKnee, {0, 0, 0}, {0, -0.085, -0.006}, 0.0345, 0.033, kShankLength, kKneeGirth, kCalfGirth},
      {kLeftKnee, {0, -0.085, -0.006}, {0, -0.243, -0.010}, 0.033, 0.0205, kShankLength, kCalfGirth, kAnkleGirth},
      {kLeftAnkle,
       {0, -0.016, -0.020},
       {0, -0.024, 0.085},
       0.022,
       0.016,
       kFootLength,
       kFootGirth,
       kFootGirth,
       1.4,
       {},
       true},
  }};
  constexpr std::size_t kMiddle = 5;
  constexpr std::size_t kLeft = 8;
  static_assert(kMiddle + 2 * kLeft == kBodyParts);
  constexpr std::array<Joint, kLeft> kRight = {kRightClavicle, kRightShoulder, kRightElbow, kRightWrist,
                                               kRightHip,      kRightKnee,     kRightKnee,  kRightAnkle};
  for (std::size_t i = 0; i < kLeft; ++i) {
    BodyPart part = parts[kMiddle + i];
    part.bone = kRight[i];
    part.a.x() *= -1;
    part.b.x() *= -1;
    parts[kMiddle + kLeft + i] = part;
  }
  return parts;
}

Vec stretched(const PartShape& part, const Vec& v) { return {part.width * v.x(), v.y(), v.z()}; }

// Unit vectors about a unit axis, which is the last.
std::array<Vec, 3> frame_about(const Vec& axis) {
  const Vec across = axis.unitOrthogonal();
  return {across, axis.cross(across), axis};
}

class Sampler {
public:
  Sampler() : body_(pose_body(BodyPose(), Shape::Zero())) {
    for (std::size_t i = 0; i < kBodyParts; ++i) {
      add_side(i);
      if (body_parts()[i].has_tip) add_tip(i);
    }
  }
  const std::vector<BodySample>& samples() const { return samples_; }

private:
  // Rings about the cone.
  void add_side(std::size_t index) {
    const PartShape& part = body_.parts[index];
    const int rings = std::max(1, static_cast<int>(std::lround(part.length / kSampleSpacing)));
    for (int i = 0; i < rings; ++i) add_ring(index, (i + 0.5) / rings, part.sin_half_angle, part.length / rings);
  }

  // Rings about the sphere at b.
  void add_tip(std::size_t index) {
    const double radius = body_.parts[index].radius_b;
    const int rings = std::max(1, static_cast<int>(std::lround(radius * std::numbers::pi / 2 / kSampleSpacing)));
    for (int i = 0; i < rings; ++i) {
      const double elevation = std::numbers::pi / 2 * (i + 0.5) / rings;
      add_ring(index, 1, std::sin(elevation), radius * std::numbers::pi / 2 / rings);
    }
  }

  // `rise`: of the directions along the axis.
  void add_ring(std::size_t index, double along, double rise, double breadth) {
    const PartShape& part = body_.parts[index];
    const auto frame = frame_about(part.axis);
    const double radius = part.radius_a + along * (part.radius_b - part.radius_a);
    const double flat = std::sqrt(1 - rise * rise);
    const double length = std::numbers::pi * radius * flat * (1 + part.width);
    const int count = std::max(3, static_cast<int>(std::lround(length / kSampleSpacing)));
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.5) / count;
      const Vec direction = flat * (std::cos(angle) * frame[0] + std::sin(angle) * frame[1]) + rise * frame[2];
      const PartPoint point{along, direction};
      if (!is_hidden(index, position_of(part, point))) samples_.push_back({index, point, length / count * breadth});
    }
  }

  bool is_hidden(std::size_t part_index, const Vec& position) const {
    const Vec world = body_.bones[body_parts()[part_index].bone] * position;
    for (std::size_t i = 0; i < kBodyParts; ++i) {
      const SE3& bone = body_.bones[body_parts()[i].bone];
      if (i != part_index && closest_surface(body_.parts[i], bone.inverse() * world).distance < -kHidden) return true;
    }
    return false;
  }

  PosedBody body_;
  std::vector<BodySample> samples_;
};

} // namespace

const std::array<BodyPart, kBodyParts>& body_parts() {
  static const std::array<BodyPart, kBodyParts> parts = build_parts();
  return parts;
}

PartShape shape_of(const BodyPart& part, const Shape& shape) {
  const double height = kMeanHeight * std::exp(shape[kHeight]);
  const double length = height * std::exp(shape[part.length]);
  PartShape result;
  result.a = length * part.a;
  result.b = length * part.b;
  result.radius_a = height * std::exp(shape[part.girth_a]) * part.radius_a;
  result.radius_b = height * std::exp(shape[part.girth_b]) * part.radius_b;
  result.width = part.width * (part.width_measure ? std::exp(shape[*part.width_measure]) : 1.0);
  result.length = (result.b - result.a).norm();
  result.axis = (result.b - result.a) / result.length;
  result.sin_half_angle = std::clamp((result.radius_a - result.radius_b) / result.length, -0.95, 0.95);
  result.tan_half_angle = result.sin_half_angle / std::sqrt(1 - result.sin_half_angle * result.sin_half_angle);
  result.centre = stretched(result, 0.5 * (result.a + result.b));
  result.reach = std::max(1.0, result.width) * (0.5 * result.length + std::max(result.radius_a, result.radius_b));
  return result;
}

Vec position_of(const PartShape& part, const PartPoint& point) {
  const double radius = part.radius_a + point.along * (part.radius_b - part.radius_a);
  return stretched(part, part.a + point.along * (part.b - part.a) + radius * point.direction);
}

Vec gradient_of(const PartShape& part, const PartPoint& point) {
  return {point.direction.x() / part.width, point.direction.y(), point.direction.z()};
}

Vec normal_of(const PartShape& part, const PartPoint& point) { return gradient_of(part, point).normalized(); }

// The hull of two spheres is touched at a right angle by the sphere whose centre lies where the way to the point leans
// against the axis by the cone's slope. Stretching is undone first; the gradient's length then says what a step is
// worth.
ClosestSurface closest_surface(const PartShape& part, const Vec& position) {
  const double narrowing = 1 / part.width;
  const Vec from_a(narrowing * position.x() - part.a.x(), position.y() - part.a.y(), position.z() - part.a.z());
  const double height = from_a.dot(part.axis);
  const double across = std::sqrt(std::max(0.0, from_a.squaredNorm() - height * height));
  const double reached = std::clamp(height - across * part.tan_half_angle, 0.0, part.length);
  const Vec offset = from_a - reached * part.axis;
  const double distance = offset.norm();
  const double radius = part.radius_a - reached * part.sin_half_angle;
  const Vec direction = distance > 1e-9 ? Vec(offset * (1 / distance)) : Vec(part.axis.unitOrthogonal());
  const Vec gradient(narrowing * direction.x(), direction.y(), direction.z());
  const double flatness = 1 / gradient.norm();
  return {(distance - radius) * flatness, gradient * flatness, {reached / part.length, direction}};
}

Eigen::Matrix<double, kPartMeasures, 1> measure_derivative(const PartShape& part, const PartPoint& point,
                                                           const Vec& direction) {
  const Vec centre = stretched(part, part.a + point.along * (part.b - part.a));
  const double outward = stretched(part, point.direction).dot(direction);
  const Vec position = position_of(part, point);
  Eigen::Matrix<double, kPartMeasures, 1> result;
  result << centre.dot(direction), (1 - point.along) * part.radius_a * outward, point.along * part.radius_b * outward,
      position.x() * direction.x(), position.dot(direction);
  return result;
}

std::array<std::optional<Measure>, kPartMeasures> measures_of(const BodyPart& part) {
  return {part.length, part.girth_a, part.girth_b, part.width_measure, kHeight};
}

std::span<const BodySample> body_samples() {
  static const std::vector<BodySample> samples = Sampler().samples();
  return samples;
}

std::span<const BodySample> samples_of(std::size_t part) {
  const std::span<const BodySample> all = body_samples();
  const auto first_from = [all](std::size_t least) {
    return std::partition_point(all.begin(), all.end(), [least](const BodySample& s) { return s.part < least; });
  };
  return {first_from(part), first_from(part + 1)};
}

PosedBody pose_body(const BodyPose& pose, const Shape& shape) {
  PosedBody body{forward_kinematics(pose, shape), {}};
  for (std::size_t i = 0; i < kBodyParts; ++i) body.parts[i] = shape_of(body_parts()[i], shape);
  return body;
}

} // namespace kinora::tracking
