#include "tracking/model/surface_graph.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace kinora::tracking {
namespace {

constexpr double kCell = 0.015;

// A flat sheet in x–y, facing `facing` along z.
void add_sheet(double x0, double x1, double z, float facing, std::vector<SurfacePoint>& points) {
  for (double x = x0; x < x1; x += 0.005) {
    for (double y = 0; y < 0.2; y += 0.005) {
      points.push_back({Eigen::Vector3d(x, y, z).cast<float>(), Eigen::Vector3f(0, 0, facing), 0, 1});
    }
  }
}

std::vector<GraphEdge> edges_of(std::span<const Eigen::Vector3d> nodes, std::span<const SurfaceSample> samples,
                                double spacing, double cell) {
  SurfaceEdges edges;
  edges.extend(nodes, samples, spacing, cell);
  return edges.edges();
}

struct Graph {
  std::vector<SurfaceSample> samples;
  std::vector<Eigen::Vector3d> nodes;
  std::vector<GraphEdge> edges;

  explicit Graph(const std::vector<SurfacePoint>& points, double spacing = 0.045) {
    samples = downsample_surface(points, kCell, 0);
    add_nodes(samples, spacing, 1000, nodes);
    edges = edges_of(nodes, samples, spacing, kCell);
  }
};

TEST(SurfaceGraph, NodesLieApartAndCoverTheSurface) {
  std::vector<SurfacePoint> points;
  add_sheet(0, 0.4, 0, -1, points);
  const Graph graph(points);
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE((graph.nodes[i] - graph.nodes[j]).norm(), 0.045);
  }
  for (const SurfacePoint& point : points) {
    const bool covered = std::any_of(graph.nodes.begin(), graph.nodes.end(), [&](const Eigen::Vector3d& node) {
      return (node - point.position.cast<double>()).norm() < 0.045 + 2 * kCell;
    });
    EXPECT_TRUE(covered);
  }
}

TEST(SurfaceGraph, EveryNodeOfASheetHasNeighbours) {
  std::vector<SurfacePoint> points;
  add_sheet(0, 0.4, 0, -1, points);
  const Graph graph(points);
  std::vector<int> degree(graph.nodes.size());
  for (const GraphEdge& edge : graph.edges) {
    EXPECT_LT(edge.a, edge.b);
    ++degree[static_cast<std::size_t>(edge.a)];
    ++degree[static_cast<std::size_t>(edge.b)];
  }
  EXPECT_GE(*std::min_element(degree.begin(), degree.end()), 4);
}

TEST(SurfaceGraph, SheetsThatLieOnEachOtherAreTiedOnlyToFollow) {
  // An arm before the chest: 5 cm apart, far along the surface.
  std::vector<SurfacePoint> points;
  add_sheet(0, 0.4, 0, -1, points);
  add_sheet(0.1, 0.3, -0.05, -1, points);
  const Graph graph(points);
  const auto across = std::count_if(graph.edges.begin(), graph.edges.end(), [&](const GraphEdge& edge) {
    return std::abs(graph.nodes[static_cast<std::size_t>(edge.a)].z() -
                    graph.nodes[static_cast<std::size_t>(edge.b)].z()) > 0.025;
  });
  EXPECT_GE(across, 1);
  EXPECT_LE(across, 3);
}

TEST(SurfaceGraph, FrontAndBackOfAThinSheetAreNotNeighbours) {
  std::vector<SurfacePoint> points;
  add_sheet(0, 0.4, 0, -1, points);
  add_sheet(0, 0.4, 0.012, 1, points);
  const auto samples = downsample_surface(points, 0.008, 0);
  std::vector<Eigen::Vector3d> nodes;
  for (double x = 0.1; x < 0.35; x += 0.05) {
    nodes.emplace_back(x, 0.1, 0);
    nodes.emplace_back(x, 0.1, 0.012);
  }
  const auto edges = edges_of(nodes, samples, 0.05, 0.008);
  const auto across =
      std::count_if(edges.begin(), edges.end(), [](const GraphEdge& e) { return (e.a + e.b) % 2 != 0; });
  EXPECT_LE(across, 3);
  EXPECT_GT(edges.size(), 4U);
}

TEST(SurfaceGraph, OldNodesStayTheFirstAndTheLimitHolds) {
  std::vector<SurfacePoint> points;
  add_sheet(0, 0.2, 0, -1, points);
  std::vector<Eigen::Vector3d> nodes;
  add_nodes(downsample_surface(points, kCell, 0), 0.045, 1000, nodes);
  const std::vector<Eigen::Vector3d> before = nodes;
  add_sheet(0.2, 0.6, 0, -1, points);
  add_nodes(downsample_surface(points, kCell, 0), 0.045, before.size() + 3, nodes);
  ASSERT_EQ(nodes.size(), before.size() + 3);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), nodes.begin()));
  for (std::size_t i = before.size(); i < nodes.size(); ++i) EXPECT_GT(nodes[i].x(), 0.2);
}

TEST(SurfaceGraph, EdgesThatGrowAreThoseOfTheWhole) {
  constexpr double kSpacing = 0.045;
  std::vector<SurfacePoint> points;
  add_sheet(0, 0.8, 0, -1, points);
  const auto samples = downsample_surface(points, kCell, 0);
  std::vector<Eigen::Vector3d> nodes;
  add_nodes(samples, kSpacing, 1000, nodes);
  std::stable_sort(nodes.begin(), nodes.end(), [](const auto& a, const auto& b) { return a.x() < b.x(); });
  const std::size_t half = nodes.size() / 2;
  std::vector<SurfaceSample> right; // what is near to the new half
  const double reach = 2 * EdgeConfig().reach * kSpacing + 2 * kCell;
  for (const SurfaceSample& sample : samples) {
    if (sample.position.x() > nodes[half].x() - reach) right.push_back(sample);
  }
  ASSERT_LT(right.size(), samples.size());
  SurfaceEdges growing;
  growing.extend(std::span(nodes).first(half), samples, kSpacing, kCell);
  growing.extend(nodes, right, kSpacing, kCell);
  const std::vector<GraphEdge> whole = edges_of(nodes, samples, kSpacing, kCell);
  EXPECT_TRUE(std::equal(growing.edges().begin(), growing.edges().end(), whole.begin(), whole.end(),
                         [](const GraphEdge& a, const GraphEdge& b) { return a.a == b.a && a.b == b.b; }));
}

TEST(SurfaceGraph, ASurfaceSeenTooSeldomGetsNoNodes) {
  std::vector<SurfacePoint> points;
  add_sheet(0, 0.2, 0, -1, points);
  EXPECT_TRUE(downsample_surface(points, kCell, 2).empty());
}

} // namespace
} // namespace kinora::tracking
