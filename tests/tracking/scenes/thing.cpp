#include "thing.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace kinora::tracking::testing {
namespace {

using Vec = Eigen::Vector3d;

// Values in [0, 1] at cells of a grid: a mosaic.
double cell_noise(const Vec& at, std::uint64_t seed) {
  std::uint64_t key = seed;
  for (int axis = 0; axis < 3; ++axis) {
    key = mix64(key ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(at[axis]))));
  }
  return Random(key).uniform_double();
}

// Spots of about two centimetres on a ground of two colours.
Vec print(const Vec& at, std::uint64_t seed) {
  const Vec ground = Vec(0.75, 0.70, 0.60) * (0.55 + 0.45 * cell_noise(at / 0.045, seed));
  const bool spot = cell_noise(at / 0.018, seed + 1) > 0.6;
  return spot ? Vec(0.12 + 0.2 * cell_noise(at / 0.1, seed + 2), 0.15, 0.35) : ground;
}

double box_distance(const Vec& half, const Vec& p) {
  const Vec q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

double rod_distance(double along, double half, double across, double radius) {
  return std::max(std::abs(along) - half, across - radius);
}

double vase_radius(double y) {
  const double share = (y + 0.13) / 0.26; // from the foot
  return 0.045 + 0.045 * std::pow(std::sin(3.1416 * std::clamp(0.12 + 0.8 * share, 0.0, 1.0)), 2);
}

double vase_distance(const Vec& p) {
  constexpr double kSteepest = 0.85; // cosine of the profile's slope
  const double across = std::hypot(p.x(), p.z());
  const double body = std::max(kSteepest * (across - vase_radius(p.y())), std::abs(p.y()) - 0.13);
  const Vec ring = p - Vec(0.075, 0.055, 0);
  const double handle = std::hypot(std::hypot(ring.x(), ring.y()) - 0.035, ring.z()) - 0.009;
  return std::min(body, handle);
}

} // namespace

Vec Thing::normal(const Vec& position) const {
  constexpr double kStep = 1e-4;
  Vec gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec step = kStep * Vec::Unit(axis);
    gradient[axis] = distance(position + step) - distance(position - step);
  }
  return gradient.normalized();
}

Thing vase(bool printed) {
  const auto colour = [printed](const Vec& p) -> Vec { return printed ? print(p, 11) : Vec(0.20, 0.42, 0.55); };
  return {0.18, vase_distance, colour, 0.25};
}

Thing mallet() {
  const auto distance = [](const Vec& p) {
    const double head = rod_distance(p.x(), 0.07, std::hypot(p.y() - 0.10, p.z()), 0.042);
    return std::min(head, rod_distance(p.y() + 0.07, 0.17, std::hypot(p.x(), p.z()), 0.014));
  };
  const auto colour = [](const Vec& p) -> Vec {
    const double grain = cell_noise({p.x() / 0.03, p.y() / 0.2, p.z() / 0.012}, 3);
    return (0.7 + 0.3 * grain) * Vec(0.55, 0.36, 0.18);
  };
  return {0.26, distance, colour};
}

Thing ball(double radius, bool striped) {
  const auto colour = [striped](const Vec& p) -> Vec {
    const bool band = striped && std::sin(6 * std::atan2(p.z(), p.x())) * (p.y() > 0 ? 1 : -1) > 0;
    return band ? Vec(0.10, 0.12, 0.45) : Vec(0.75, 0.30, 0.20);
  };
  return {radius + 0.01, [radius](const Vec& p) { return p.norm() - radius; }, colour};
}

Thing printed_box(const Vec& half, std::uint64_t seed) {
  return {half.norm() + 0.01, [half](const Vec& p) { return box_distance(half, p); },
          [seed](const Vec& p) { return print(p + Vec(0.003, 0.007, 0.005), seed); }};
}

Thing plain_box(const Vec& half, const Vec& colour) {
  return {half.norm() + 0.01, [half](const Vec& p) { return box_distance(half, p); },
          [colour](const Vec&) { return colour; }};
}

} // namespace kinora::tracking::testing
