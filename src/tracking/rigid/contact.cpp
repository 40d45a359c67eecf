#include "tracking/rigid/contact.h"

#include <algorithm>

namespace kinora::tracking {
namespace {

bool is_near(const NearbyObject& object, const Eigen::Vector3d& in_object, double reach) {
  const Eigen::Vector3f position = (in_object - object.origin).cast<float>();
  const auto squared = static_cast<float>(reach * reach);
  return std::any_of(object.surface.begin(), object.surface.end(),
                     [&](const SurfacePoint& point) { return (point.position - position).squaredNorm() < squared; });
}

} // namespace

std::optional<NearbyObject> nearby_object(const RigidTracker& tracker) {
  if (tracker.poses().empty() || tracker.poses().back().health != motion::Health::kTracked) return std::nullopt;
  return NearbyObject{tracker.label(), tracker.poses().back().canonical_to_world, tracker.surface(),
                      tracker.model()->origin()};
}

void ContactTracker::update(std::span<const NearbyObject> objects, std::span<const Eigen::Vector3d> positions,
                            std::span<const double> seen) {
  for (const NearbyObject& object : objects) {
    std::vector<std::optional<MeanPosition>>& means = means_[object.label];
    means.resize(positions.size());
    const SE3 to_object = object.canonical_to_world.inverse();
    for (std::size_t n = 0; n < positions.size(); ++n) {
      const Eigen::Vector3d in_object = to_object * positions[n];
      std::optional<MeanPosition>& mean = means[n];
      if (!mean && seen[n] <= config_.min_visible) continue;
      if (!mean) mean = MeanPosition{in_object, positions[n]};
      if (seen[n] > config_.min_visible) classify(object, in_object, positions[n], *mean);
      const double share = config_.update_rate * seen[n];
      mean->in_object += share * (in_object - mean->in_object);
      mean->in_world += share * (positions[n] - mean->in_world);
    }
  }
}

void ContactTracker::classify(const NearbyObject& object, const Eigen::Vector3d& in_object,
                              const Eigen::Vector3d& in_world, MeanPosition& mean) const {
  const double travelled = (in_world - mean.in_world).norm();
  const double slipped = (in_object - mean.in_object).norm();
  if (slipped > config_.max_slip * std::max(travelled, config_.min_motion)) {
    mean.in_contact = false;
  } else if (!mean.in_contact && (config_.assumes_contact || travelled > config_.min_motion)) {
    mean.in_contact = is_near(object, in_object, config_.reach);
  }
}

std::optional<Eigen::Vector3d> ContactTracker::position_of(std::size_t point,
                                                           std::span<const NearbyObject> objects) const {
  for (const NearbyObject& object : objects) {
    if (is_in_contact(point, object.label))
      return object.canonical_to_world * means_.at(object.label)[point]->in_object;
  }
  return std::nullopt;
}

bool ContactTracker::is_in_contact(std::size_t point, int label) const {
  const auto found = means_.find(label);
  if (found == means_.end() || point >= found->second.size()) return false;
  const std::optional<MeanPosition>& mean = found->second[point];
  return mean && mean->in_contact;
}

} // namespace kinora::tracking
