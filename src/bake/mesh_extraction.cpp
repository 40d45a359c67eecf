#include "bake/mesh_extraction.h"

#include <cmath>

#include "core/error.h"
#include "core/parallel.h"
#include "fields/network/vector_features.h"

namespace kinora::bake {
namespace {

constexpr int kCoarsest = 16; ///< cells per side
constexpr int kFirst = 96;    ///< cells per side of the surface that the number of triangles is judged by

void check(const MeshExtractionOptions& options) {
  if (options.triangles < 1 || options.resolution < 0 || options.resolution > fields::FieldLimits::kMaxResolution ||
      !(options.opacity > 0 && options.opacity < 1) ||
      !(options.min_component_share >= 0 && options.min_component_share <= 1)) {
    throw Error(ErrorCode::kUsage, "a surface needs at least 1 triangle, a resolution up to 8192, and an opacity "
                                   "between 0 and 1");
  }
}

/// Faces grow with the square of the resolution.
int resolution_for(std::size_t wanted, std::size_t faces, int resolution, int finest) {
  const double scale = std::sqrt(static_cast<double>(wanted) / static_cast<double>(std::max<std::size_t>(1, faces)));
  return std::clamp(static_cast<int>(std::floor(resolution * scale)), std::min(kCoarsest, finest), finest);
}

Triangles triangulate(const FieldSampler& sampler, const MeshExtractionOptions& options, const Progress& progress) {
  const fields::FieldConfig& config = sampler.field().config;
  const double level = -std::log(1 - options.opacity) / config.cell_size();
  const auto at = [&](int resolution) {
    Triangles triangles = surface_nets(sampler, level, resolution, progress);
    remove_small_components(triangles, options.min_component_share);
    return triangles;
  };
  if (options.resolution > 0) return at(options.resolution);
  const int finest = config.finest_resolution;
  int resolution = std::min(kFirst, finest);
  Triangles triangles = at(resolution);
  // The first guess counts too little where a coarse grid misses thin parts: look again if it was far too low.
  for (int attempt = 0; attempt < 2; ++attempt) {
    const int better = resolution_for(options.triangles, triangles.faces.size(), resolution, finest);
    const bool too_many = static_cast<double>(triangles.faces.size()) > 1.1 * static_cast<double>(options.triangles);
    if (better == resolution || (attempt > 0 && !too_many)) break;
    resolution = better;
    triangles = at(resolution);
  }
  return triangles;
}

/// Frames spread over the clip, in whose light a layer is seen.
std::vector<motion::Warp> sampled_warps(const motion::Motion& motion) {
  constexpr std::size_t kFrames = 8;
  std::vector<int> seen;
  for (std::size_t f = 0; f < std::max(motion.poses().size(), motion.deformations().size()); ++f) {
    if (motion.health(f) == motion::Health::kTracked) seen.push_back(static_cast<int>(f));
  }
  if (seen.empty()) seen = {0};
  const std::size_t count = std::min(kFrames, seen.size());
  std::vector<motion::Warp> warps;
  for (std::size_t k = 0; k < count; ++k) warps.push_back(motion.warp(seen[(2 * k + 1) * seen.size() / (2 * count)]));
  return warps;
}

fields::Rotation rotation_at(const motion::Warp& warp, const Eigen::Vector3d& canonical) {
  if (warp.is_rigid()) return fields::rotation_of(warp.rigid().linear());
  const auto pose = warp.at(canonical);
  return pose ? fields::rotation_of(pose->linear()) : fields::kNoRotation;
}

/// Colours of vertices: features composited along a short ray through the surface, as the renderer does, in the mean of
/// the frames' light.
void color_chunk(const FieldSampler& sampler, std::span<const motion::Warp> warps, const Triangles& triangles,
                 std::span<const Eigen::Vector3d> normals, const Chunk& chunk,
                 std::span<std::array<std::uint8_t, 3>> colors) {
  constexpr int kBefore = 2; // samples in front of the surface
  constexpr int kSamples = 8;
  const double step = sampler.field().config.cell_size();
  std::vector<Eigen::Vector3d> points;
  for (std::size_t v = chunk.begin; v < chunk.end; ++v) {
    for (int k = 0; k < kSamples; ++k) points.emplace_back(triangles.positions[v] - (k - kBefore) * step * normals[v]);
  }
  FieldSamples samples;
  sampler.evaluate(points, samples);
  std::vector<std::array<float, FieldSamples::kFeatures>> features(chunk.end - chunk.begin);
  for (std::size_t v = 0; v < features.size(); ++v) {
    float transmittance = 1;
    for (std::size_t k = v * kSamples; k < (v + 1) * kSamples; ++k) {
      const float behind = transmittance * std::exp(-samples.density[k] * static_cast<float>(step));
      for (std::size_t f = 0; f < FieldSamples::kFeatures; ++f) {
        features[v][f] += (transmittance - behind) * samples.features[k][f];
      }
      transmittance = behind;
    }
    for (float& f : features[v]) f /= std::max(1 - transmittance, 1e-6F);
  }
  std::vector<Eigen::Array3f> sums(features.size(), Eigen::Array3f::Zero());
  for (const motion::Warp& warp : warps) {
    auto rotated = features;
    for (std::size_t v = 0; v < features.size(); ++v) {
      fields::rotate_vectors(rotation_at(warp, triangles.positions[chunk.begin + v]), rotated[v].data());
    }
    const auto shaded = sampler.colors(rotated);
    for (std::size_t v = 0; v < features.size(); ++v) sums[v] += Eigen::Map<const Eigen::Array3f>(shaded[v].data());
  }
  for (std::size_t v = 0; v < features.size(); ++v) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float mean = sums[v][static_cast<Eigen::Index>(c)] / static_cast<float>(warps.size());
      colors[chunk.begin + v][c] = static_cast<std::uint8_t>(std::lround(255 * mean));
    }
  }
}

} // namespace

std::optional<host::Mesh> extract_mesh(const clip::Layer& layer, const MeshExtractionOptions& options,
                                       const Progress& progress) {
  check(options);
  const FieldSampler sampler(layer.field);
  Triangles triangles = triangulate(sampler, options, progress);
  if (const auto& graph = layer.motion.graph()) {
    std::vector<std::uint8_t> moved(triangles.positions.size());
    parallel_for(moved.size(), 4096, [&](const Chunk& chunk) {
      for (std::size_t v = chunk.begin; v < chunk.end; ++v) {
        moved[v] = graph->influence(triangles.positions[v]).count > 0 ? 1 : 0;
      }
    });
    keep_vertices(triangles, moved);
  }
  if (triangles.faces.empty()) return std::nullopt;
  const std::vector<Eigen::Vector3d> normals = vertex_normals(triangles);
  host::Mesh mesh;
  mesh.name = layer.name;
  mesh.colors.resize(triangles.positions.size());
  const std::vector<motion::Warp> warps = sampled_warps(layer.motion);
  parallel_for(mesh.colors.size(), 2048,
               [&](const Chunk& chunk) { color_chunk(sampler, warps, triangles, normals, chunk, mesh.colors); });
  for (const Eigen::Vector3d& p : triangles.positions) mesh.positions.emplace_back(p.cast<float>());
  for (const Eigen::Vector3d& n : normals) mesh.normals.emplace_back(n.cast<float>());
  mesh.faces = std::move(triangles.faces);
  return mesh;
}

} // namespace kinora::bake
