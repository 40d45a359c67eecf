#include "tracking/model/surface_graph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

namespace kinora::tracking {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The thinned surface as a graph: samples side by side whose normals do not point apart. A sample's links are found
/// when they are asked for: walks pass by few samples.
class SampleGraph {
public:
  struct Link {
    int to;
    double length;
  };

  SampleGraph(std::span<const SurfaceSample> samples, double sample_spacing)
      : samples_(samples), nearest_(positions_of(samples), 2.2 * sample_spacing), links_(samples.size()) {}

  std::size_t size() const { return samples_.size(); }

  std::span<const Link> of(int sample) {
    const auto i = static_cast<std::size_t>(sample);
    Links& links = links_[i];
    if (links.count < 0) {
      std::array<motion::NearestPoints::Neighbour, kMax> found{};
      const std::size_t count = nearest_.find(samples_[i].position, found);
      links.count = 0;
      for (std::size_t k = 0; k < count; ++k) {
        const auto j = static_cast<std::size_t>(found[k].index);
        if (j == i || samples_[i].normal.dot(samples_[j].normal) < 0) continue;
        if (links.count == 0) links.begin = all_.size();
        all_.push_back({found[k].index, std::sqrt(found[k].squared_distance)});
        ++links.count;
      }
    }
    return std::span(all_).subspan(links.begin, static_cast<std::size_t>(links.count));
  }

private:
  static constexpr std::size_t kMax = 24;
  struct Links {
    std::size_t begin = 0;
    int count = -1; ///< not found yet
  };

  static std::vector<Eigen::Vector3d> positions_of(std::span<const SurfaceSample> samples) {
    std::vector<Eigen::Vector3d> positions;
    positions.reserve(samples.size());
    for (const SurfaceSample& sample : samples) positions.push_back(sample.position);
    return positions;
  }

  std::span<const SurfaceSample> samples_;
  motion::NearestPoints nearest_;
  std::vector<Links> links_; ///< of each sample, in `all_`
  std::vector<Link> all_;
};

/// Walks along the surface from one sample to others, in order of distance. Reusable.
class GeodesicSearch {
public:
  explicit GeodesicSearch(SampleGraph& links) : links_(links), distance_(links.size(), kInfinity) {}

  /// Calls `visit(sample, distance)` for each sample within reach, the nearest first, until it returns false.
  template <class Visit> void visit_nearest(int start, double reach, const Visit& visit) {
    for (const int i : reached_) distance_[static_cast<std::size_t>(i)] = kInfinity;
    reached_.clear();
    queue_.clear();
    distance_[static_cast<std::size_t>(start)] = 0;
    reached_.push_back(start);
    queue_.emplace_back(0, start);
    while (!queue_.empty()) {
      std::pop_heap(queue_.begin(), queue_.end(), std::greater<>());
      const auto [length, at] = queue_.back();
      queue_.pop_back();
      if (length > distance_[static_cast<std::size_t>(at)]) continue;
      if (!visit(at, length)) return;
      for (const SampleGraph::Link& link : links_.of(at)) {
        const double next = length + link.length;
        double& known = distance_[static_cast<std::size_t>(link.to)];
        if (next > reach || next >= known) continue;
        if (known == kInfinity) reached_.push_back(link.to);
        known = next;
        queue_.emplace_back(next, link.to);
        std::push_heap(queue_.begin(), queue_.end(), std::greater<>());
      }
    }
  }

private:
  SampleGraph& links_;
  std::vector<double> distance_;
  std::vector<int> reached_;
  std::vector<std::pair<double, int>> queue_; ///< a heap
};

std::vector<int> nearest_samples(std::span<const Eigen::Vector3d> nodes, std::span<const SurfaceSample> samples,
                                 double reach) {
  std::vector<Eigen::Vector3d> positions;
  for (const SurfaceSample& sample : samples) positions.push_back(sample.position);
  const motion::NearestPoints nearest(positions, reach);
  std::vector<int> result;
  result.reserve(nodes.size());
  for (const Eigen::Vector3d& node : nodes) {
    std::array<motion::NearestPoints::Neighbour, 1> found{};
    result.push_back(nearest.find(node, found) > 0 ? found[0].index : -1);
  }
  return result;
}

/// Which nodes hang together.
class DisjointSets {
public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
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
void connect_components(std::span<const Eigen::Vector3d> nodes, std::set<std::pair<int, int>>& edges) {
  constexpr std::size_t kBridges = 3;
  DisjointSets components(nodes.size());
  for (const auto& [a, b] : edges) components.join(a, b);
  const int count = static_cast<int>(nodes.size());
  while (true) {
    // The last piece, by the number of its first node, goes to its nearest neighbour.
    int component = 0;
    for (int i = 0; i < count; ++i) component = std::max(component, components.of(i));
    if (component == 0) return;
    std::vector<std::pair<double, std::pair<int, int>>> lines;
    for (int i = 0; i < count; ++i) {
      if (components.of(i) != component) continue;
      double best = kInfinity;
      int other = -1;
      for (int j = 0; j < count; ++j) {
        if (components.of(j) == component) continue;
        const double squared = (nodes[static_cast<std::size_t>(i)] - nodes[static_cast<std::size_t>(j)]).squaredNorm();
        if (squared < best) {
          best = squared;
          other = j;
        }
      }
      lines.push_back({best, {std::min(i, other), std::max(i, other)}});
    }
    std::sort(lines.begin(), lines.end());
    for (std::size_t k = 0; k < std::min(kBridges, lines.size()); ++k) {
      edges.insert(lines[k].second);
      components.join(lines[k].second.first, lines[k].second.second);
    }
  }
}

} // namespace

void SurfaceEdges::extend(std::span<const Eigen::Vector3d> nodes, std::span<const SurfaceSample> samples,
                          double spacing, double sample_spacing, const EdgeConfig& config) {
  const std::size_t old = neighbours_.size();
  neighbours_.resize(nodes.size());
  SampleGraph links(samples, sample_spacing);
  const std::vector<int> sample_of = nearest_samples(nodes, samples, 2 * sample_spacing);
  std::vector<std::vector<int>> nodes_at(samples.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (sample_of[i] >= 0) nodes_at[static_cast<std::size_t>(sample_of[i])].push_back(static_cast<int>(i));
  }
  const double reach = config.reach * spacing;
  const motion::NearestPoints added(nodes.subspan(old), reach);
  GeodesicSearch paths(links);
  std::array<motion::NearestPoints::Neighbour, 1> beside{};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (sample_of[i] < 0 || (i < old && added.find(nodes[i], beside) == 0)) continue;
    std::vector<int>& found = neighbours_[i];
    found.clear();
    paths.visit_nearest(sample_of[i], reach, [&](int sample, double along) {
      for (const int j : nodes_at[static_cast<std::size_t>(sample)]) {
        const auto other = static_cast<std::size_t>(j);
        // Half a sample at both ends is no detour.
        const double longest = config.max_detour * ((nodes[i] - nodes[other]).norm() + sample_spacing);
        if (other == i || along > longest || found.size() == config.neighbours) continue;
        found.push_back(j);
      }
      return found.size() < config.neighbours;
    });
  }
  std::set<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const int j : neighbours_[i]) pairs.insert(std::minmax(static_cast<int>(i), j));
  }
  connect_components(nodes, pairs);
  edges_.clear();
  for (const auto& [a, b] : pairs) edges_.push_back({a, b});
}

} // namespace kinora::tracking
