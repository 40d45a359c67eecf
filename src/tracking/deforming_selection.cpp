#include "tracking/deforming_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "ingest/sensor_noise.h"
#include "tracking/residuals.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kPointsPerChunk = 512;

// What a view shows at a place of the camera's space, on all levels; NaN unless the layer is measured there.
std::array<float, ObjectView::kLevels> texture_at(const ObjectView& view, const Eigen::Vector3d& place) {
  std::array<float, ObjectView::kLevels> texture{};
  texture.fill(std::numeric_limits<float>::quiet_NaN());
  if (!(place.z() > 0)) return texture;
  const Eigen::Vector2d pixel = view.intrinsics.project(place);
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < view.intrinsics.width - 1 &&
        pixel.y() < view.intrinsics.height - 1)) {
    return texture;
  }
  const int u = static_cast<int>(std::lround(pixel.x()));
  const int v = static_cast<int>(std::lround(pixel.y()));
  const double tolerance = std::max(0.015, 3 * ingest::depth_sigma(place.z()));
  if (view.mask.at(u, v) != 2 || view.planes.weights.at(u, v) <= 0 ||
      std::abs(view.point(u, v).z() - place.z()) > tolerance) {
    return texture;
  }
  for (std::size_t level = 0; level < texture.size(); ++level) {
    texture[level] = view.sample_texture(static_cast<int>(level), pixel.x(), pixel.y()).value;
  }
  return texture;
}

bool faces_camera(const PosedPoint& point, const ObjectView& view) {
  const Eigen::Vector3d place = point.place.cast<double>();
  if (!(place.z() > 0) || point.normal.dot(point.place) > 0) return false;
  const Eigen::Vector2d pixel = view.intrinsics.project(place);
  return pixel.x() > 0 && pixel.y() > 0 && pixel.x() < view.intrinsics.width && pixel.y() < view.intrinsics.height;
}

} // namespace

void DeformingSelection::add_last_view(const ObjectView& view, const NodeStates& states) {
  const LayerPose pose = pose_layer(points, states);
  parallel_for(points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    for (std::size_t k = chunk.begin; k < chunk.end; ++k) {
      textures[k].last = texture_at(view, pose.points[k].place.cast<double>());
    }
  });
}

DeformingSelection select_facing(std::span<const SurfacePoint> surface, std::span<const Influence> skin,
                                 const ObjectView& view, const NodeStates& states, std::size_t max_points,
                                 const std::function<bool(const Influence&)>& takes_part) {
  std::vector<std::uint8_t> chosen(surface.size(), 0);
  const std::vector<NodeRow> nodes = rows_of(states);
  parallel_for(surface.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    std::vector<std::size_t> which;
    std::vector<SkinnedPoint> points;
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      if (skin[i].count == 0 || (takes_part && !takes_part(skin[i]))) continue;
      which.push_back(i);
      points.emplace_back(surface[i].position, surface[i].normal, skin[i]);
    }
    std::vector<PosedPoint> posed(points.size());
    pose_points(points, nodes, posed);
    for (std::size_t k = 0; k < which.size(); ++k) chosen[which[k]] = faces_camera(posed[k], view) ? 1 : 0;
  });
  const std::size_t count = static_cast<std::size_t>(std::count(chosen.begin(), chosen.end(), 1));
  const std::size_t wanted = std::min(count, max_points);
  DeformingSelection selection;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    if (chosen[i] == 0) continue;
    ++seen;
    if (seen * wanted / count == (seen - 1) * wanted / count) continue; // every count/wanted-th of them
    selection.points.emplace_back(surface[i].position, surface[i].normal, skin[i]);
    PointTexture texture;
    texture.fused = surface[i].intensity;
    texture.direction = direction_of(surface[i].normal);
    texture.last.fill(std::numeric_limits<float>::quiet_NaN());
    selection.textures.push_back(texture);
  }
  return selection;
}

} // namespace kinora::tracking
