#include "tracking/camera/loop_closure.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "core/parallel.h"

namespace kinora::tracking {
namespace {

// Changes of view, in radians and metres over the distance of what is seen (view_change).
constexpr double kUncertainEdgeLength = 5; // as far as which the way over an edge of less weight counts
constexpr std::size_t kMinMatches = 15;

/// The least change of view along edges from one key frame to each other.
std::vector<double> graph_distances(std::size_t start, std::span<const CameraKeyframe> keyframes,
                                    std::span<const PoseEdge> edges) {
  std::vector<std::vector<std::pair<std::size_t, double>>> steps(keyframes.size());
  for (const PoseEdge& edge : edges) {
    const double length =
        view_change(edge.to_in_from, keyframes[edge.from].distance) + (edge.weight < 1 ? kUncertainEdgeLength : 0);
    steps[edge.from].emplace_back(edge.to, length);
    steps[edge.to].emplace_back(edge.from, length);
  }
  std::vector<double> distances(keyframes.size(), std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, std::size_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
  distances[start] = 0;
  queue.emplace(0.0, start);
  while (!queue.empty()) {
    const auto [distance, k] = queue.top();
    queue.pop();
    if (distance > distances[k]) continue;
    for (const auto& [next, length] : steps[k]) {
      if (distance + length >= distances[next]) continue;
      distances[next] = distance + length;
      queue.emplace(distances[next], next);
    }
  }
  return distances;
}

double max_drift(double distance, const LoopClosureConfig& config) {
  return config.drift + config.drift_rate * distance;
}

// Where a loop says that its newer key frame is.
SE3 loop_pose(const PoseEdge& loop, std::span<const SE3> map) { return map[loop.from] * loop.to_in_from; }

// Whether both loops would move the map about a newer key frame alike.
bool are_consistent(const PoseEdge& a, const PoseEdge& b, std::span<const SE3> map, double distance,
                    const LoopClosureConfig& config) {
  const SE3 by_a = loop_pose(a, map);
  const SE3 by_b = loop_pose(b, map) * (map[b.to].inverse() * map[a.to]);
  return view_change(by_a.inverse() * by_b, distance) < config.agreement;
}

bool is_consistent(const std::vector<PoseEdge>& loops, std::span<const CameraKeyframe> keyframes,
                   std::span<const SE3> map, std::span<const PoseEdge> edges, const LoopClosureConfig& config) {
  std::vector<PoseEdge> all(edges.begin(), edges.end());
  all.insert(all.end(), loops.begin(), loops.end());
  std::vector<SE3> optimised(map.begin(), map.end());
  optimise_poses(all, keyframes.front().distance, optimised);
  return std::all_of(all.begin(), all.end(), [&](const PoseEdge& edge) {
    const SE3 residual = edge.to_in_from.inverse() * optimised[edge.from].inverse() * optimised[edge.to];
    return edge.weight < 1 || view_change(residual, keyframes[edge.to].distance) < config.residual;
  });
}

} // namespace

std::vector<std::size_t> most_similar(const SurfaceFeatures& features, std::span<const CameraKeyframe> keyframes,
                                      std::span<const std::size_t> among, std::size_t count) {
  std::vector<std::pair<std::size_t, std::size_t>> order(among.size());
  parallel_for(among.size(), 4, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      order[i] = {count_matches(keyframes[among[i]].features, features), among[i]};
    }
  });
  std::erase_if(order, [](const auto& entry) { return entry.first < kMinMatches; });
  std::sort(order.begin(), order.end(), std::greater<>());
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < std::min(count, order.size()); ++i) result.push_back(order[i].second);
  return result;
}

std::vector<PoseEdge> LoopClosure::find_loops(std::span<const CameraKeyframe> keyframes, const LayerView& view,
                                              std::span<const SE3> map, std::span<const PoseEdge> edges) {
  const std::size_t newest = keyframes.size() - 1;
  std::erase_if(candidates_, [&](const PoseEdge& loop) { return loop.to + config_.window <= newest; });
  const std::vector<double> distances = graph_distances(newest, keyframes, edges);
  std::vector<std::size_t> distant;
  for (std::size_t k = 0; k < newest; ++k) {
    if (max_drift(distances[k], config_) > config_.reach) distant.push_back(k);
  }
  bool found = false;
  for (const std::size_t k : most_similar(keyframes[newest].features, keyframes, distant, config_.compared)) {
    const auto start = register_by_features(keyframes[k].features, keyframes[newest].features);
    if (!start) continue;
    const auto measured = relative_pose(keyframes[k], keyframes[newest], view, *start);
    if (!measured) continue;
    const PoseEdge loop{k, newest, *measured};
    const SE3 drift = map[newest].inverse() * loop_pose(loop, map);
    if (view_change(drift, keyframes[newest].distance) > max_drift(distances[k], config_)) continue;
    candidates_.push_back(loop);
    found = true;
  }
  if (!found) return {};
  std::vector<PoseEdge> loops;
  std::vector<std::size_t> witnesses;
  for (const PoseEdge& loop : candidates_) {
    if (!are_consistent(candidates_.back(), loop, map, keyframes[newest].distance, config_)) continue;
    loops.push_back(loop);
    if (witnesses.empty() || witnesses.back() != loop.to) witnesses.push_back(loop.to);
  }
  const bool contradicted = 4 * loops.size() < 3 * candidates_.size(); // places that look alike
  if (witnesses.size() < config_.min_witnesses || contradicted || !is_consistent(loops, keyframes, map, edges, config_))
    return {};
  candidates_.clear();
  return loops;
}

} // namespace kinora::tracking
