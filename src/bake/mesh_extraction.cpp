#include "bake/mesh_extraction.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "bake/flat_surface.h"
#include "bake/simplification.h"
#include "bake/texture_baking.h"
#include "core/error.h"
#include "core/parallel.h"

namespace kinora::bake {
namespace {

constexpr int kMaxTexture = 8192;
constexpr int kCoarsest = 16; ///< cells per side
constexpr int kFirst = 96;    ///< cells per side of the surface that the number of triangles is judged by

void check(const MeshExtractionOptions& options) {
  if (options.triangles < 1 || options.resolution < 0 || options.resolution > fields::FieldLimits::kMaxResolution ||
      !(options.opacity > 0 && options.opacity < 1) ||
      !(options.min_component_share >= 0 && options.min_component_share <= 1) || !(options.simplification >= 0) ||
      !(options.still_simplification >= 0) || !(options.flat_simplification >= 0) ||
      !(options.still_component_share >= 0 && options.still_component_share <= 1) || options.texture < 0 ||
      options.texture > kMaxTexture) {
    throw Error(ErrorCode::kUsage, "a surface needs at least 1 triangle, a resolution up to 8192, an opacity "
                                   "between 0 and 1, and a texture of at most 8192 pixels per side");
  }
}

/// Faces grow with the square of the resolution.
int resolution_for(std::size_t wanted, std::size_t faces, int resolution, int finest) {
  const double scale = std::sqrt(static_cast<double>(wanted) / static_cast<double>(std::max<std::size_t>(1, faces)));
  return std::clamp(static_cast<int>(std::floor(resolution * scale)), std::min(kCoarsest, finest), finest);
}

/// The density (extinction per metre) at which the surface is. Fields that were trained briefly are soft: where no cell
/// is as opaque as asked, the surface would be in pieces.
double surface_level(const FieldSampler& sampler, double opacity, const Progress& progress) {
  constexpr double kShare = 0.9;
  constexpr std::size_t kSide = 128;
  const fields::FieldConfig& config = sampler.field().config;
  std::vector<std::vector<float>> slices(kSide);
  parallel_for(kSide, 1, [&](const Chunk& chunk) {
    progress.check();
    std::vector<Eigen::Vector3d> points;
    for (std::size_t i = 0; i < kSide * kSide; ++i) {
      const std::size_t row = i / kSide;
      const Eigen::Vector3d at(static_cast<double>(i % kSide), static_cast<double>(row),
                               static_cast<double>(chunk.begin));
      const Eigen::Vector3d point =
          config.box.origin + (at + Eigen::Vector3d::Constant(0.5)) * (config.box.side / static_cast<double>(kSide));
      if (sampler.occupied(point)) points.push_back(point);
    }
    FieldSamples samples;
    sampler.evaluate(points, samples);
    slices[chunk.begin] = std::move(samples.density);
  });
  std::vector<float> densities;
  for (const std::vector<float>& slice : slices) densities.insert(densities.end(), slice.begin(), slice.end());
  std::sort(densities.begin(), densities.end(), std::greater<>());
  const auto opacity_of = [&config](float density) { return 1 - std::exp(-density * config.cell_size()); };
  double total = 0;
  for (const float density : densities) total += opacity_of(density);
  double above = 0;
  const double level = -std::log(1 - opacity) / config.cell_size();
  for (const float density : densities) {
    above += opacity_of(density);
    if (above < kShare * total) continue;
    return std::min<double>(level, density);
  }
  return level;
}

Triangles triangulate(const FieldSampler& sampler, const MeshExtractionOptions& options, double component_share,
                      const Progress& progress) {
  const fields::FieldConfig& config = sampler.field().config;
  const double level = surface_level(sampler, options.opacity, progress);
  const auto at = [&](int resolution) {
    Triangles triangles = surface_nets(sampler, level, resolution, progress);
    remove_small_components(triangles, component_share);
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

/// Leaves out what no node moves.
void keep_moved(const motion::Motion& motion, Triangles& triangles) {
  const auto& graph = motion.graph();
  if (!graph) return;
  std::vector<std::uint8_t> moved(triangles.positions.size());
  parallel_for(moved.size(), 4096, [&](const Chunk& chunk) {
    for (std::size_t v = chunk.begin; v < chunk.end; ++v)
      moved[v] = graph->influence(triangles.positions[v]).count > 0 ? 1 : 0;
  });
  keep_vertices(triangles, moved);
}

/// Fewer triangles. Returns by how many metres the surface may be off.
double simplify_layer(const clip::Layer& layer, bool still, const MeshExtractionOptions& options,
                      Triangles& triangles) {
  constexpr double kFlat = 0.1;
  double error = still ? options.still_simplification : options.simplification;
  if (still && options.flat_simplification > error && is_flat(triangles, kFlat)) {
    error = options.flat_simplification;
    if (layer.confidence) smooth_unseen(layer.field.config.box, *layer.confidence, triangles);
  }
  if (error > 0) simplify(triangles, error, 4);
  return error;
}

/// The vertices of the mesh as the atlas has them, and the picture.
void add_texture(const clip::Layer& layer, const FieldSampler& sampler, const MeshExtractionOptions& options,
                 double error, const Triangles& triangles, std::span<const Eigen::Vector3d> normals,
                 const Progress& progress, host::Mesh& mesh) {
  constexpr double kPixelsPerCell = 1.5;
  const double cell = sampler.field().config.cell_size();
  const TextureAtlas atlas = texture_atlas(triangles, cell / kPixelsPerCell, options.texture, progress);
  for (std::size_t v = 0; v < atlas.sources.size(); ++v) {
    mesh.positions.emplace_back(triangles.positions[atlas.sources[v]].cast<float>());
    mesh.normals.emplace_back(normals[atlas.sources[v]].cast<float>());
    mesh.texture_coordinates.emplace_back(atlas.coordinates[v].x() / static_cast<float>(atlas.width),
                                          atlas.coordinates[v].y() / static_cast<float>(atlas.height));
  }
  mesh.faces = atlas.faces;
  mesh.texture = bake_texture(atlas, triangles, normals, sampler, layer.motion, error + 2 * cell, progress);
}

void add_vertex_colors(const clip::Layer& layer, const FieldSampler& sampler, Triangles& triangles,
                       std::span<const Eigen::Vector3d> normals, const Progress& progress, host::Mesh& mesh) {
  std::vector<SurfacePoint> points;
  for (std::size_t v = 0; v < normals.size(); ++v) {
    points.push_back({triangles.positions[v], normals[v]});
    mesh.positions.emplace_back(triangles.positions[v].cast<float>());
    mesh.normals.emplace_back(normals[v].cast<float>());
  }
  mesh.colors = surface_colors(sampler, layer.motion, points, 0, progress);
  mesh.faces = std::move(triangles.faces);
}

} // namespace

std::optional<host::Mesh> extract_mesh(const clip::Layer& layer, const MeshExtractionOptions& options,
                                       const Progress& progress) {
  check(options);
  const FieldSampler sampler(layer.field);
  const bool still = layer.motion.kind() == motion::MotionKind::kStill;
  Triangles triangles =
      triangulate(sampler, options, still ? options.still_component_share : options.min_component_share, progress);
  keep_moved(layer.motion, triangles);
  const double error = simplify_layer(layer, still, options, triangles);
  if (triangles.faces.empty()) return std::nullopt;
  const std::vector<Eigen::Vector3d> normals = vertex_normals(triangles);
  host::Mesh mesh;
  mesh.name = layer.name;
  if (options.texture > 0) {
    add_texture(layer, sampler, options, error, triangles, normals, progress, mesh);
  } else {
    add_vertex_colors(layer, sampler, triangles, normals, progress, mesh);
  }
  return mesh;
}

} // namespace kinora::bake
