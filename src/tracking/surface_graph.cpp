#include "tracking/surface_graph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>
#include <set>
#include <utility>

#include "core/parallel.h"

namespace kinora::tracking {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kNodesPerChunk = 16;

/// The thinned surface as a graph: samples side by side whose normals do not point apart.
struct SampleLinks {
  struct Link {
    int to;
    double length;
  };
  std::vector<std::vector<Link>> links;

  SampleLinks(std::span<const SurfaceSample> samples, double sample_spacing) : links(samples.size()) {
    std::vector<Eigen::Vector3d> positions;
    for (const SurfaceSample& sample : samples) positions.push_back(sample.position);
    const NearestPoints nearest(positions, 2.2 * sample_spacing);
    parallel_for(samples.size(), 256, [&](const Chunk& chunk) {
      std::array<NearestPoints::Neighbour, 24> found{};
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const std::size_t count = nearest.find(positions[i], found);
        for (std::size_t k = 0; k < count; ++k) {
          const auto j = static_cast<std::size_t>(found[k].index);
          if (j == i || samples[i].normal.dot(samples[j].normal) < 0) continue;
          links[i].push_back({found[k].index, std::sqrt(found[k].squared_distance)});
        }
      }
    });
  }
};

/// Distances along the surface from one sample to those within reach; the rest stays infinite. Reusable.
class SurfacePaths {
public:
  explicit SurfacePaths(const SampleLinks& links) : links_(links), distance_(links.links.size(), kInfinity) {}

  const std::vector<double>& from(int start, double reach) {
    for (const int i : reached_) distance_[static_cast<std::size_t>(i)] = kInfinity;
    reached_.clear();
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    distance_[static_cast<std::size_t>(start)] = 0;
    reached_.push_back(start);
    queue.emplace(0, start);
    while (!queue.empty()) {
      const auto [length, at] = queue.top();
      queue.pop();
      if (length > distance_[static_cast<std::size_t>(at)]) continue;
      for (const SampleLinks::Link& link : links_.links[static_cast<std::size_t>(at)]) {
        const double next = length + link.length;
        double& known = distance_[static_cast<std::size_t>(link.to)];
        if (next > reach || next >= known) continue;
        if (known == kInfinity) reached_.push_back(link.to);
        known = next;
        queue.emplace(next, link.to);
      }
    }
    return distance_;
  }

private:
  const SampleLinks& links_;
  std::vector<double> distance_;
  std::vector<int> reached_;
};

std::vector<int> nearest_samples(std::span<const Eigen::Vector3d> nodes, std::span<const SurfaceSample> samples,
                                 double reach) {
  std::vector<Eigen::Vector3d> positions;
  for (const SurfaceSample& sample : samples) positions.push_back(sample.position);
  const NearestPoints nearest(positions, reach);
  std::vector<int> result;
  result.reserve(nodes.size());
  for (const Eigen::Vector3d& node : nodes) {
    std::array<NearestPoints::Neighbour, 1> found{};
    result.push_back(nearest.find(node, found) > 0 ? found[0].index : -1);
  }
  return result;
}

/// Which nodes hang together.
class Pieces {
public:
  explicit Pieces(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int of(int i) {
    while (parent_[static_cast<std::size_t>(i)] != i) i = parent_[static_cast<std::size_t>(i)];
    return i;
  }
  void join(int a, int b) {
    const int first = std::min(of(a), of(b));
    const int second = std::max(of(a), of(b));
    parent_[static_cast<std::size_t>(second)] = first;
  }

private:
  std::vector<int> parent_;
};

// Ties each piece to its nearest other one, by its three shortest straight lines, until all is one.
void tie_pieces(std::span<const Eigen::Vector3d> nodes, std::set<std::pair<int, int>>& edges) {
  constexpr std::size_t kTies = 3;
  Pieces pieces(nodes.size());
  for (const auto& [a, b] : edges) pieces.join(a, b);
  const int count = static_cast<int>(nodes.size());
  while (true) {
    // The last piece, by the number of its first node, goes to its nearest neighbour.
    int piece = 0;
    for (int i = 0; i < count; ++i) piece = std::max(piece, pieces.of(i));
    if (piece == 0) return;
    std::vector<std::pair<double, std::pair<int, int>>> lines;
    for (int i = 0; i < count; ++i) {
      if (pieces.of(i) != piece) continue;
      double best = kInfinity;
      int other = -1;
      for (int j = 0; j < count; ++j) {
        if (pieces.of(j) == piece) continue;
        const double squared = (nodes[static_cast<std::size_t>(i)] - nodes[static_cast<std::size_t>(j)]).squaredNorm();
        if (squared < best) {
          best = squared;
          other = j;
        }
      }
      lines.push_back({best, {std::min(i, other), std::max(i, other)}});
    }
    std::sort(lines.begin(), lines.end());
    for (std::size_t k = 0; k < std::min(kTies, lines.size()); ++k) {
      edges.insert(lines[k].second);
      pieces.join(lines[k].second.first, lines[k].second.second);
    }
  }
}

} // namespace

std::vector<SurfaceSample> thin_surface(std::span<const SurfacePoint> surface, double cell, float min_weight) {
  using Key = std::array<int, 3>;
  std::vector<std::pair<Key, std::size_t>> order;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    if (surface[i].weight < min_weight) continue;
    const Eigen::Vector3d c = surface[i].position.cast<double>() / cell;
    order.push_back({{static_cast<int>(std::floor(c.x())), static_cast<int>(std::floor(c.y())),
                      static_cast<int>(std::floor(c.z()))},
                     i});
  }
  // Within a cell the heaviest comes first, equal weights in order.
  std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
    if (a.first != b.first) return a.first < b.first;
    if (surface[a.second].weight != surface[b.second].weight) {
      return surface[a.second].weight > surface[b.second].weight;
    }
    return a.second < b.second;
  });
  std::vector<SurfaceSample> result;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i > 0 && order[i].first == order[i - 1].first) continue;
    const SurfacePoint& point = surface[order[i].second];
    result.push_back({point.position.cast<double>(), point.normal.cast<double>()});
  }
  return result;
}

void add_nodes(std::span<const SurfaceSample> samples, double spacing, std::size_t limit,
               std::vector<Eigen::Vector3d>& nodes) {
  const NearestPoints before(nodes, spacing);
  const std::size_t old = nodes.size();
  std::array<NearestPoints::Neighbour, 1> found{};
  for (const SurfaceSample& sample : samples) {
    if (nodes.size() >= limit) return;
    if (before.find(sample.position, found) > 0) continue;
    const bool crowded = std::any_of(nodes.begin() + static_cast<std::ptrdiff_t>(old), nodes.end(), [&](const auto& n) {
      return (n - sample.position).squaredNorm() < spacing * spacing;
    });
    if (!crowded) nodes.push_back(sample.position);
  }
}

std::vector<GraphEdge> connect_nodes(std::span<const Eigen::Vector3d> nodes, std::span<const SurfaceSample> samples,
                                     double spacing, double sample_spacing, const EdgeConfig& config) {
  const SampleLinks links(samples, sample_spacing);
  const std::vector<int> sample_of = nearest_samples(nodes, samples, 2 * sample_spacing);
  const double reach = config.reach * spacing;
  std::vector<std::vector<std::pair<int, int>>> found(chunk_count(nodes.size(), kNodesPerChunk));
  parallel_for(nodes.size(), kNodesPerChunk, [&](const Chunk& chunk) {
    SurfacePaths paths(links);
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      if (sample_of[i] < 0) continue;
      const std::vector<double>& distance = paths.from(sample_of[i], reach);
      std::vector<std::pair<double, int>> near;
      for (std::size_t j = 0; j < nodes.size(); ++j) {
        if (j == i || sample_of[j] < 0) continue;
        const double along = distance[static_cast<std::size_t>(sample_of[j])];
        // Half a sample at both ends is no detour.
        if (along == kInfinity || along > config.max_detour * ((nodes[i] - nodes[j]).norm() + sample_spacing)) {
          continue;
        }
        near.emplace_back(along, static_cast<int>(j));
      }
      const std::size_t kept = std::min(near.size(), static_cast<std::size_t>(config.neighbours));
      std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(kept), near.end());
      for (std::size_t k = 0; k < kept; ++k) {
        found[chunk.index].emplace_back(std::min(static_cast<int>(i), near[k].second),
                                        std::max(static_cast<int>(i), near[k].second));
      }
    }
  });
  std::set<std::pair<int, int>> edges;
  for (const auto& part : found) edges.insert(part.begin(), part.end());
  tie_pieces(nodes, edges);
  std::vector<GraphEdge> result;
  result.reserve(edges.size());
  for (const auto& [a, b] : edges) result.push_back({a, b});
  return result;
}

} // namespace kinora::tracking
