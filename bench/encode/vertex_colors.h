// Depth fusion's picture of a layer: a mesh as fine as a fused volume, whose vertices have the mean colour of all
// frames that saw them (Guo et al., "Real-time Geometry, Albedo and Motion Reconstruction", TOG 36(3), 2017, without
// light).
#pragma once

#include <cmath>
#include <optional>
#include <span>

#include "bake/mesh_extraction.h"
#include "fields/rendering/renderer.h"
#include "ingest/frame/frame.h"
#include "motion/motion.h"

namespace kinora::bench {

constexpr double kFusedVoxel = 0.004; ///< metres, as the tracker's volume has it

inline std::optional<host::Mesh> fused_mesh(const clip::Layer& layer) {
  bake::MeshExtractionOptions options;
  options.resolution =
      std::min(layer.field.config.finest_resolution, static_cast<int>(layer.field.config.box.side / kFusedVoxel));
  return bake::extract_mesh(layer, options, Progress());
}

/// Where a canonical vertex is in a camera.
inline Eigen::Vector3d in_camera(const motion::Warp& warp, const Camera& camera, const Eigen::Vector3f& vertex) {
  const Eigen::Vector3d canonical = vertex.cast<double>();
  return camera.camera_to_world.inverse() * warp.to_world(canonical).value_or(canonical);
}

/// Frames and their numbers in the motion. Vertices that none sees become grey.
inline void color_vertices(const motion::Motion& motion, int label,
                           std::span<const std::pair<int, std::shared_ptr<const ingest::Frame>>> frames,
                           host::Mesh& mesh) {
  constexpr double kSeen = 0.01; // metres from what is measured there
  std::vector<Eigen::Vector4d> sums(mesh.positions.size(), Eigen::Vector4d::Zero());
  for (const auto& [number, frame] : frames) {
    const motion::Warp warp = motion.warp(number);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const Eigen::Vector3d point = in_camera(warp, frame->camera, mesh.positions[i]);
      const Eigen::Vector2d pixel = frame->camera.intrinsics.project(point);
      const int u = static_cast<int>(std::lround(pixel.x()));
      const int v = static_cast<int>(std::lround(pixel.y()));
      if (!frame->depth.contains(u, v) || frame->label_at(u, v) != label) continue;
      if (std::abs(frame->depth.at(u, v) - point.z()) > kSeen) continue;
      const std::uint8_t* rgb = frame->color.pixel(u, v);
      sums[i] += Eigen::Vector4d(rgb[0], rgb[1], rgb[2], 1);
    }
  }
  mesh.colors.assign(sums.size(), {128, 128, 128});
  for (std::size_t i = 0; i < sums.size(); ++i) {
    for (std::size_t c = 0; c < 3 && sums[i][3] > 0; ++c)
      mesh.colors[i][c] = static_cast<std::uint8_t>(std::lround(sums[i][static_cast<int>(c)] / sums[i][3]));
  }
}

/// Into what is drawn already, with a depth test; colours between vertices are linear in the picture.
inline void draw_mesh(const host::Mesh& mesh, const motion::Warp& warp, const Camera& camera,
                      fields::Picture& picture) {
  std::vector<Eigen::Vector3d> corners; // u, v, depth
  corners.reserve(mesh.positions.size());
  for (const Eigen::Vector3f& vertex : mesh.positions) {
    const Eigen::Vector3d point = in_camera(warp, camera, vertex);
    corners.emplace_back(0, 0, point.z());
    if (point.z() > 0.05) corners.back().head<2>() = camera.intrinsics.project(point);
  }
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3d& a = corners[face[0]];
    const Eigen::Vector3d& b = corners[face[1]];
    const Eigen::Vector3d& c = corners[face[2]];
    if (std::min({a.z(), b.z(), c.z()}) < 0.05) continue;
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0) continue;
    const auto least = [&](int i) { return static_cast<int>(std::ceil(std::min({a[i], b[i], c[i]}))); };
    const auto most = [&](int i) { return static_cast<int>(std::floor(std::max({a[i], b[i], c[i]}))); };
    for (int v = std::max(0, least(1)); v <= std::min(picture.depth.height() - 1, most(1)); ++v) {
      for (int u = std::max(0, least(0)); u <= std::min(picture.depth.width() - 1, most(0)); ++u) {
        const auto part = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
          return ((q.x() - p.x()) * (v - p.y()) - (q.y() - p.y()) * (u - p.x())) / area;
        };
        const Eigen::Vector3d weights(part(b, c), part(c, a), part(a, b));
        if (weights.minCoeff() < 0) continue;
        const auto depth = static_cast<float>(weights.dot(Eigen::Vector3d(a.z(), b.z(), c.z())));
        float& nearest = picture.depth.at(u, v);
        if (nearest > 0 && nearest <= depth) continue;
        nearest = depth;
        std::uint8_t* rgba = picture.color.pixel(u, v);
        rgba[3] = 255;
        for (std::size_t k = 0; k < 3; ++k) {
          const Eigen::Vector3d colors(mesh.colors[face[0]][k], mesh.colors[face[1]][k], mesh.colors[face[2]][k]);
          rgba[k] = static_cast<std::uint8_t>(std::lround(std::clamp(weights.dot(colors), 0.0, 255.0)));
        }
      }
    }
  }
}

} // namespace kinora::bench
