#include "bake/nearest_layer.h"

#include <limits>

#include "bake/mesh_extraction.h"
#include "clip/shown_frames.h"
#include "core/parallel.h"

namespace kinora::bake {
namespace {

/// Source: Ericson, "Real-Time Collision Detection" (2005), sec. 5.1.5.
Eigen::Vector3d closest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double denominator = va + vb + vc;
  return a + ab * (vb / denominator) + ac * (vc / denominator);
}

/// A layer's surface in the world.
struct LiveSurface {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<std::uint32_t, 3>> faces;
  double longest_edge = 0;

  double squared_distance(const Eigen::Vector3d& p, double limit) const {
    double best = limit;
    for (const auto& face : faces) {
      const Eigen::Vector3d& a = positions[face[0]];
      const double reach = std::sqrt(best) + longest_edge;
      const double away = (p - a).squaredNorm();
      if (away > reach * reach) continue;
      best = std::min(best, (p - closest_on_triangle(p, a, positions[face[1]], positions[face[2]])).squaredNorm());
    }
    return best;
  }
};

LiveSurface live_surface(const clip::Layer& layer, int frame, const Progress& progress) {
  MeshExtractionOptions options;
  options.min_component_share = options.still_component_share = 0.002;
  LiveSurface surface;
  const auto mesh = extract_mesh(layer, options, progress);
  if (!mesh) return surface;
  const motion::Warp warp = layer.motion.warp(frame);
  const motion::UnbornNodes unborn = layer.births.unborn(frame);
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (const Eigen::Vector3f& p : mesh->positions) {
    const bool there = unborn.empty() || !motion::is_unborn(warp.graph()->influence(p.cast<double>()), unborn);
    surface.positions.push_back(there ? warp.to_world(p.cast<double>()).value_or(none) : none);
  }
  for (const auto& face : mesh->faces) {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      longest = std::max(longest, (surface.positions[face[k]] - surface.positions[face[(k + 1) % 3]]).norm());
    }
    const auto finite = [&](std::uint32_t v) { return surface.positions[v].allFinite(); };
    if (!std::all_of(face.begin(), face.end(), finite)) continue;
    surface.longest_edge = std::max(surface.longest_edge, longest);
    surface.faces.push_back(face);
  }
  return surface;
}

} // namespace

std::vector<std::optional<std::size_t>>
nearest_layers(const clip::Clip& clip, int frame, std::span<const Eigen::Vector3d> points, const Progress& progress) {
  std::vector<std::optional<std::size_t>> nearest(points.size());
  std::vector<double> distance(points.size(), std::numeric_limits<double>::infinity());
  for (std::size_t l = 0; l < clip.layers.size(); ++l) {
    if (!clip::shown_frames(clip.layers[l], clip.times.size()).at(frame)) continue;
    const LiveSurface surface = live_surface(clip.layers[l], frame, progress);
    parallel_for(points.size(), 4, [&](const Chunk& chunk) {
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const double candidate = surface.squared_distance(points[i], distance[i]);
        if (!(candidate < distance[i])) continue;
        distance[i] = candidate;
        nearest[i] = l;
      }
    });
  }
  return nearest;
}

} // namespace kinora::bake
