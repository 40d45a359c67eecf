// Surfaces that touch in canonical space and part: hands that were folded, arms that hung down. Points of one are moved
// by nodes of the other as well, and edges tie what has come apart. The layer then gets another canonical pose, one in
// which these surfaces are apart.
// Source: Dou et al., "Fusion4D", SIGGRAPH 2016, sec. 5 (key volumes), of which this keeps one at a time.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tracking/carried_lanes.h"
#include "tracking/deforming_tracker.h"
#include "tracking/rigid_pose.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kMost = 32; // neighbours of a node that are looked at

bool are_parted(double distance, double squared_distance_there, double spacing, const TopologyChangeConfig& config) {
  const double apart = distance + config.apart * spacing;
  return squared_distance_there > apart * apart;
}

/// Pairs of nodes that are near each other in one pose and apart in another.
std::vector<std::array<std::size_t, 2>> parted_pairs(std::span<const Eigen::Vector3d> near,
                                                     std::span<const Eigen::Vector3d> apart, double spacing,
                                                     const TopologyChangeConfig& config) {
  std::vector<std::array<std::size_t, 2>> pairs;
  const NearestPoints nearest(near, config.near * spacing);
  std::array<NearestPoints::Neighbour, kMost> found{};
  for (std::size_t a = 0; a < near.size(); ++a) {
    const std::size_t count = nearest.find(near[a], found);
    for (std::size_t k = 0; k < count; ++k) {
      const auto b = static_cast<std::size_t>(found[k].index);
      if (b <= a) continue;
      const double squared = (apart[a] - apart[b]).squaredNorm();
      if (are_parted(std::sqrt(found[k].squared_distance), squared, spacing, config)) pairs.push_back({a, b});
    }
  }
  return pairs;
}

} // namespace

// Nodes that are near in canonical space and apart in the last two frames, if its pose would be the better canonical
// one: few that are apart so far would be near. `seen`: of each node; what is hidden proves nothing.
std::vector<std::size_t> DeformingTracker::parted_nodes(std::span<const double> seen) const {
  const std::vector<SE3>& before = records_[records_.size() - 2].nodes;
  std::vector<Eigen::Vector3d> now;
  for (std::size_t n = 0; n < nodes_.size(); ++n) now.push_back(records_.back().nodes[n] * nodes_[n]);
  std::vector<std::size_t> parted;
  for (const auto& [a, b] : parted_pairs(nodes_, now, spacing_, config_.topology)) {
    const double squared_before = (before[a] * nodes_[a] - before[b] * nodes_[b]).squaredNorm();
    const bool was_apart = are_parted((nodes_[a] - nodes_[b]).norm(), squared_before, spacing_, config_.topology);
    if (was_apart && seen[a] > 0 && seen[b] > 0) parted.insert(parted.end(), {a, b});
  }
  const std::size_t pairs = parted.size() / 2;
  if (pairs < config_.topology.min_pairs ||
      pairs < config_.topology.min_ratio * parted_pairs(now, nodes_, spacing_, config_.topology).size())
    return {};
  return parted;
}

// The last frame's pose without what it has stretched, but for edges that tie what has parted.
std::vector<SE3> DeformingTracker::opened_pose() const {
  const std::vector<SE3>& now = records_.back().nodes;
  std::vector<GraphEdge> holding;
  for (const GraphEdge& edge : edges()) {
    const auto a = static_cast<std::size_t>(edge.a);
    const auto b = static_cast<std::size_t>(edge.b);
    const double stretch = (now[a] * nodes_[a] - now[b] * nodes_[b]).norm() / (nodes_[a] - nodes_[b]).norm();
    if (stretch < config_.topology.max_stretch) holding.push_back(edge);
  }
  return rigid_pose(nodes_, holding, now, config_.topology.pull);
}

// The last frame's pose becomes the canonical one. What the model knows goes along, each piece with its own nodes, and
// all motion goes on as it was. `parted` nodes, which were glued while they parted, are followed back from here.
void DeformingTracker::take_pose_for_canonical(std::span<const std::size_t> parted) {
  const std::vector<SE3> pose = opened_pose(); // from the canonical space so far to the next
  const std::vector<Eigen::Vector3d> old_nodes = nodes_;
  std::vector<Eigen::Quaterniond> turns;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    nodes_[n] = pose[n] * old_nodes[n];
    turns.emplace_back(pose[n].linear());
  }
  for (Record& record : records_) {
    for (std::size_t n = 0; n < record.nodes.size(); ++n) {
      record.nodes[n] = renormalized(record.nodes[n] * pose[n].inverse());
    }
  }
  for (const std::size_t n : parted) births_[n] = records_.size() - 1;
  body_.turn_nodes_back(turns);
  PoseLibrary library;
  for (const PoseLibrary::Entry& entry : library_.entries()) {
    library.add(entry.frame, entry.world_to_camera, records_[entry.frame].nodes);
  }
  library_ = std::move(library);
  carry_model(old_nodes, pose);
  edges_ = {};
  connect_graph(0, 0);
  renew_skin();
}

// Volume, surface and graph when nodes have gone from their `old_nodes` by `pose`.
void DeformingTracker::carry_model(std::span<const Eigen::Vector3d> old_nodes, std::span<const SE3> pose) {
  std::vector<SurfacePoint> surface(surface_.points().begin(), surface_.points().end());
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const Influence& influence = surface_.skin()[i];
    if (influence.count == 0) continue;
    const SE3& carrier = pose[static_cast<std::size_t>(influence.nodes[0])];
    surface[i].position = (carrier * surface[i].position.cast<double>()).cast<float>();
  }
  const std::unique_ptr<TsdfVolume> old_volume = std::move(volume_);
  const std::shared_ptr<const DeformationGraph> old_graph = graph_;
  volume_ = std::make_unique<TsdfVolume>(old_volume->config(), old_volume->origin());
  volume_->make_bricks(surface);
  graph_ = std::make_shared<DeformationGraph>(nodes_, old_graph->weight_radius(), old_graph->influence_radius());
  influences_ = {};
  influences_.renew(*volume_, graph_);
  // What lay where a place comes from was another piece's if it does not come back to it.
  NodeStates there;
  NodeStates back;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    there.push_back(pose[n], old_nodes[n]);
    back.push_back(SE3(pose[n].inverse()), nodes_[n]);
  }
  const std::vector<float> transforms_there = packed_transforms(there);
  const std::vector<float> transforms_back = packed_transforms(back);
  const auto band = static_cast<float>(old_volume->config().truncation);
  volume_->take(*old_volume, [&](std::size_t brick, const PointLanes& points, PointLanes& places) {
    InfluenceLanes influences;
    influences_.weigh(brick, points, influences);
    carry_points(transforms_back, influences, points, places);
    for (std::size_t i = 0; i < PointLanes::kPoints; ++i) {
      const Eigen::Vector3f place = places.at(i);
      influences.set(i, place.allFinite() ? old_graph->influence(place.cast<double>()) : Influence());
    }
    PointLanes again{};
    carry_points(transforms_there, influences, places, again);
    for (std::size_t i = 0; i < PointLanes::kPoints; ++i) {
      const bool stays = (again.at(i) - points.at(i)).norm() <= band;
      if (!stays) places.set(i, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
    }
  });
  surface_ = {};
  surface_.renew_points(*volume_, {}, unit_weight_);
}

} // namespace kinora::tracking
