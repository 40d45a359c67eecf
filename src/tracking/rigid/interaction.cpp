#include "tracking/rigid/interaction.h"

#include <algorithm>

namespace kinora::tracking {
namespace {

bool is_near(const NearbyObject& object, const Eigen::Vector3d& in_object, double reach) {
  const Eigen::Vector3f place = (in_object - object.origin).cast<float>();
  const auto squared = static_cast<float>(reach * reach);
  return std::any_of(object.surface.begin(), object.surface.end(),
                     [&](const SurfacePoint& point) { return (point.position - place).squaredNorm() < squared; });
}

} // namespace

std::optional<NearbyObject> nearby_object(const RigidTracker& tracker) {
  if (tracker.poses().empty() || tracker.poses().back().health != motion::Health::kTracked) return std::nullopt;
  return NearbyObject{tracker.label(), tracker.poses().back().canonical_to_world, tracker.surface(),
                      tracker.model()->origin()};
}

void Interaction::learn(std::span<const NearbyObject> objects, std::span<const Eigen::Vector3d> places,
                        std::span<const double> seen) {
  for (const NearbyObject& object : objects) {
    std::vector<std::optional<Mean>>& means = means_[object.label];
    means.resize(places.size());
    const SE3 to_object = object.canonical_to_world.inverse();
    for (std::size_t n = 0; n < places.size(); ++n) {
      const Eigen::Vector3d in_object = to_object * places[n];
      std::optional<Mean>& mean = means[n];
      if (!mean && seen[n] <= config_.min_seen) continue;
      if (!mean) mean = Mean{in_object, places[n]};
      if (seen[n] > config_.min_seen) decide(object, in_object, places[n], *mean);
      const double share = config_.renewed * seen[n];
      mean->in_object += share * (in_object - mean->in_object);
      mean->in_world += share * (places[n] - mean->in_world);
    }
  }
}

void Interaction::decide(const NearbyObject& object, const Eigen::Vector3d& in_object, const Eigen::Vector3d& in_world,
                         Mean& mean) const {
  const double went = (in_world - mean.in_world).norm();
  const double slipped = (in_object - mean.in_object).norm();
  if (slipped > config_.most_slip * std::max(went, config_.least_motion)) {
    mean.is_held = false;
  } else if (!mean.is_held && (config_.presumes || went > config_.least_motion)) {
    mean.is_held = is_near(object, in_object, config_.reach);
  }
}

std::optional<Eigen::Vector3d> Interaction::place_of(std::size_t number, std::span<const NearbyObject> objects) const {
  for (const NearbyObject& object : objects) {
    if (holds(number, object.label)) return object.canonical_to_world * means_.at(object.label)[number]->in_object;
  }
  return std::nullopt;
}

bool Interaction::holds(std::size_t number, int label) const {
  const auto found = means_.find(label);
  if (found == means_.end() || number >= found->second.size()) return false;
  const std::optional<Mean>& mean = found->second[number];
  return mean && mean->is_held;
}

} // namespace kinora::tracking
