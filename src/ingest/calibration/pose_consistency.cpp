#include "ingest/calibration/pose_consistency.h"

#include <array>
#include <vector>

#include "core/parallel.h"
#include "ingest/images/picture_change.h"

namespace kinora::ingest {
namespace {

constexpr int kColumns = 8;
constexpr int kRows = 6;
constexpr std::array<std::size_t, 2> kLater{2, 6}; ///< views
constexpr DepthMargin kMargin{2 * kSameSurface.metres, 2 * kSameSurface.sigmas};
constexpr double kOutOfRange = 1.5; ///< distance of what is not measured, over the farthest that is
constexpr int kMinTexture = 8;      ///< pixels of a cell that tell

struct Cell {
  int consistent = 0;
  int seen = 0;
  double squares = 0; ///< sum of squared distances
};

/// Surface in square metres per squared radian, of all cells.
struct Surface {
  double consistent = 0;
  double seen = 0;
};

float farthest(const ReducedView& view) {
  const auto depth = view.depth.values();
  return depth.empty() ? 0 : *std::max_element(depth.begin(), depth.end());
}

bool same_color_around(const ReducedView& view, int u, int v, const std::uint8_t* color) {
  for (int y = v - 1; y <= v + 1; ++y)
    for (int x = u - 1; x <= u + 1; ++x)
      if (view.color.contains(x, y) && difference(view.color.pixel(x, y), color) <= kColorChange) return true;
  return false;
}

Surface compare(const ReducedView& a, const ReducedView& b) {
  std::array<Cell, kColumns * kRows> cells;
  const SE3 a_to_b = b.camera_to_world.inverse() * a.camera_to_world;
  const double far = kOutOfRange * farthest(a);
  for (int v = 0; v < a.depth.height(); ++v) {
    for (int u = 0; u < a.depth.width(); ++u) {
      if (!has_texture(a.color, u, v)) continue;
      const double z = a.depth.at(u, v) > 0 ? static_cast<double>(a.depth.at(u, v)) : far;
      const auto seen = project_point(b.intrinsics, a_to_b * a.intrinsics.unproject(u, v, z));
      if (!seen) continue;
      const double depth_there = b.depth.at(seen->u, seen->v);
      if (is_occluded(seen->z, depth_there, kMargin)) continue;
      const bool at_depth =
          depth_there == 0 || a.depth.at(u, v) == 0 || !violates_free_space(seen->z, depth_there, kMargin);
      const int number = (v * kRows / a.depth.height()) * kColumns + u * kColumns / a.depth.width();
      Cell& cell = cells[static_cast<std::size_t>(number)];
      ++cell.seen;
      cell.squares += z * z;
      cell.consistent += at_depth && same_color_around(b, seen->u, seen->v, a.color.pixel(u, v)) ? 1 : 0;
    }
  }
  Surface surface;
  for (const Cell& cell : cells) {
    if (cell.seen < kMinTexture) continue;
    surface.seen += cell.squares / cell.seen;
    surface.consistent += cell.squares / cell.seen * cell.consistent / cell.seen;
  }
  return surface;
}

} // namespace

double photometric_geometric_consistency(std::span<const ReducedView> views) {
  std::vector<Surface> parts(views.size());
  parallel_for(views.size(), 1, [&](const Chunk& chunk) {
    for (const std::size_t later : kLater) {
      if (chunk.index + later >= views.size()) continue;
      const Surface pair = compare(views[chunk.index], views[chunk.index + later]);
      parts[chunk.index].consistent += pair.consistent;
      parts[chunk.index].seen += pair.seen;
    }
  });
  Surface all;
  for (const Surface& part : parts) {
    all.consistent += part.consistent;
    all.seen += part.seen;
  }
  return all.seen > 0 ? all.consistent / all.seen : 0;
}

} // namespace kinora::ingest
