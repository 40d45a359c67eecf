#include "tracking/deforming/deforming_point_selection.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/parallel.h"
#include "tracking/rigid/residuals.h"
#include "tracking/solver/point_association.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kPointsPerChunk = 512;

bool faces_camera(const motion::PosedPoint& point, const Intrinsics& camera) {
  const Eigen::Vector3f& position = point.position;
  if (!(position.z() > 0) || point.normal.dot(position) > 0) return false;
  const float u =
      static_cast<float>(camera.fx) * position.x() + static_cast<float>(camera.cx) * position.z(); // times z
  const float v = static_cast<float>(camera.fy) * position.y() + static_cast<float>(camera.cy) * position.z();
  return u > 0 && v > 0 && u < static_cast<float>(camera.width) * position.z() &&
         v < static_cast<float>(camera.height) * position.z();
}

} // namespace

void DeformingSelection::add_last_view(const LayerView& view, const motion::NodeStates& states) {
  const std::vector<motion::TransformRow> nodes = motion::transform_rows(states.transforms);
  parallel_for(points.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    const std::size_t count = chunk.end - chunk.begin;
    std::array<motion::PosedPoint, kPointsPerChunk> posed;
    std::array<std::array<float, LayerView::kLevels>, kPointsPerChunk> shown;
    motion::pose_points(std::span(points).subspan(chunk.begin, count), nodes, posed);
    sample_textures(std::span(posed).first(count), view, shown);
    for (std::size_t k = 0; k < count; ++k) textures[chunk.begin + k].last = shown[k];
  });
}

DeformingSelection select_facing(std::span<const SurfacePoint> surface, std::span<const motion::Influence> skin,
                                 const LayerView& view, const motion::NodeStates& states, std::size_t max_points,
                                 const std::function<bool(const motion::Influence&)>& takes_part) {
  std::vector<std::uint8_t> chosen(surface.size(), 0);
  const std::vector<motion::TransformRow> nodes = motion::transform_rows(states.transforms);
  parallel_for(surface.size(), kPointsPerChunk, [&](const Chunk& chunk) {
    std::vector<std::size_t> which;
    std::vector<motion::SkinnedPoint> points;
    which.reserve(kPointsPerChunk);
    points.reserve(kPointsPerChunk);
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      if (skin[i].count == 0 || (takes_part && !takes_part(skin[i]))) continue;
      which.push_back(i);
      points.emplace_back(surface[i].position, surface[i].normal, skin[i]);
    }
    std::vector<motion::PosedPoint> posed(points.size());
    motion::pose_points(points, nodes, posed);
    for (std::size_t k = 0; k < which.size(); ++k) chosen[which[k]] = faces_camera(posed[k], view.intrinsics) ? 1 : 0;
  });
  const std::size_t count = static_cast<std::size_t>(std::count(chosen.begin(), chosen.end(), 1));
  const std::size_t wanted = std::min(count, max_points);
  DeformingSelection selection;
  selection.points.reserve(wanted);
  selection.textures.reserve(wanted);
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
