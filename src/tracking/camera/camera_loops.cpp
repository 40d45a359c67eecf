#include "tracking/camera/camera_loops.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "core/parallel.h"

namespace kinora::tracking {
namespace {

// Changes of view, in radians and metres over the distance of what is seen (view_change).
constexpr double kDoubt = 5; // as far as which the way over an edge of less weight counts
constexpr std::size_t kMinAlike = 15;

/// The least change of view along edges from one key frame to each other.
std::vector<double> ways_from(std::size_t start, std::span<const CameraKeyframe> keyframes,
                              std::span<const PoseEdge> edges) {
  std::vector<std::vector<std::pair<std::size_t, double>>> steps(keyframes.size());
  for (const PoseEdge& edge : edges) {
    const double length = view_change(edge.to_in_from, keyframes[edge.from].distance) + (edge.weight < 1 ? kDoubt : 0);
    steps[edge.from].emplace_back(edge.to, length);
    steps[edge.to].emplace_back(edge.from, length);
  }
  std::vector<double> ways(keyframes.size(), std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, std::size_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
  ways[start] = 0;
  open.emplace(0.0, start);
  while (!open.empty()) {
    const auto [way, k] = open.top();
    open.pop();
    if (way > ways[k]) continue;
    for (const auto& [next, length] : steps[k]) {
      if (way + length >= ways[next]) continue;
      ways[next] = way + length;
      open.emplace(ways[next], next);
    }
  }
  return ways;
}

double drift_within(double way, const CameraLoopsConfig& config) { return config.drift + config.drift_share * way; }

// Where a loop says that its newer key frame is.
SE3 place_of(const PoseEdge& loop, std::span<const SE3> map) { return map[loop.from] * loop.to_in_from; }

// Whether both loops would move the map about a newer key frame alike.
bool agree(const PoseEdge& a, const PoseEdge& b, std::span<const SE3> map, double distance,
           const CameraLoopsConfig& config) {
  const SE3 by_a = place_of(a, map);
  const SE3 by_b = place_of(b, map) * (map[b.to].inverse() * map[a.to]);
  return view_change(by_a.inverse() * by_b, distance) < config.agreement;
}

bool settles(const std::vector<PoseEdge>& loops, std::span<const CameraKeyframe> keyframes, std::span<const SE3> map,
             std::span<const PoseEdge> edges, const CameraLoopsConfig& config) {
  std::vector<PoseEdge> all(edges.begin(), edges.end());
  all.insert(all.end(), loops.begin(), loops.end());
  std::vector<SE3> settled(map.begin(), map.end());
  optimise_poses(all, keyframes.front().distance, settled);
  return std::all_of(all.begin(), all.end(), [&](const PoseEdge& edge) {
    const SE3 strain = edge.to_in_from.inverse() * settled[edge.from].inverse() * settled[edge.to];
    return edge.weight < 1 || view_change(strain, keyframes[edge.to].distance) < config.strain;
  });
}

} // namespace

std::vector<std::size_t> most_alike(const SurfaceFeatures& features, std::span<const CameraKeyframe> keyframes,
                                    std::span<const std::size_t> among, std::size_t count) {
  std::vector<std::pair<std::size_t, std::size_t>> order(among.size());
  parallel_for(among.size(), 4, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      order[i] = {count_alike(keyframes[among[i]].features, features), among[i]};
    }
  });
  std::erase_if(order, [](const auto& entry) { return entry.first < kMinAlike; });
  std::sort(order.begin(), order.end(), std::greater<>());
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < std::min(count, order.size()); ++i) result.push_back(order[i].second);
  return result;
}

std::vector<PoseEdge> CameraLoops::look_back(std::span<const CameraKeyframe> keyframes, const ObjectView& view,
                                             std::span<const SE3> map, std::span<const PoseEdge> edges) {
  const std::size_t newest = keyframes.size() - 1;
  std::erase_if(seen_, [&](const PoseEdge& loop) { return loop.to + config_.window <= newest; });
  const std::vector<double> ways = ways_from(newest, keyframes, edges);
  std::vector<std::size_t> far;
  for (std::size_t k = 0; k < newest; ++k) {
    if (drift_within(ways[k], config_) > config_.reach) far.push_back(k);
  }
  bool found = false;
  for (const std::size_t k : most_alike(keyframes[newest].features, keyframes, far, config_.compared)) {
    const auto start = place_by_features(keyframes[k].features, keyframes[newest].features);
    if (!start) continue;
    const auto measured = relate(keyframes[k], keyframes[newest], view, *start);
    if (!measured) continue;
    const PoseEdge loop{k, newest, *measured};
    const SE3 drift = map[newest].inverse() * place_of(loop, map);
    if (view_change(drift, keyframes[newest].distance) > drift_within(ways[k], config_)) continue;
    seen_.push_back(loop);
    found = true;
  }
  if (!found) return {};
  std::vector<PoseEdge> loops;
  std::vector<std::size_t> witnesses;
  for (const PoseEdge& loop : seen_) {
    if (!agree(seen_.back(), loop, map, keyframes[newest].distance, config_)) continue;
    loops.push_back(loop);
    if (witnesses.empty() || witnesses.back() != loop.to) witnesses.push_back(loop.to);
  }
  const bool contradicted = 4 * loops.size() < 3 * seen_.size(); // places that look alike
  if (witnesses.size() < config_.min_witnesses || contradicted || !settles(loops, keyframes, map, edges, config_))
    return {};
  seen_.clear();
  return loops;
}

} // namespace kinora::tracking
