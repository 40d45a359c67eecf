#include "ingest/frame/reduced_view.h"

#include "core/parallel.h"
#include "ingest/frame/pixel_blocks.h"

namespace kinora::ingest {
namespace {

constexpr std::size_t kRowsPerChunk = 16;

/// The measurement nearest to the block's centre, in a fixed order.
float measurement_of(const DepthImage& depth, int left, int top, int factor) {
  const int middle = factor / 2;
  if (const float z = depth.at(left + middle, top + middle); z > 0) return z;
  for (int v = top; v < top + factor; ++v)
    for (int u = left; u < left + factor; ++u)
      if (depth.at(u, v) > 0) return depth.at(u, v);
  return 0;
}

} // namespace

ReducedView reduced_view(const Frame& frame, int factor) {
  const int width = frame.depth.width() / factor;
  const int height = frame.depth.height() / factor;
  ReducedView view{frame.camera.intrinsics, ColorImage(width, height, 3), DepthImage(width, height),
                   frame.camera.camera_to_world};
  // Pixel u of the view lies at factor·u + factor/2 of the frame.
  const int middle = factor / 2;
  Intrinsics& k = view.intrinsics;
  k = {width, height, k.fx / factor, k.fy / factor, (k.cx - middle) / factor, (k.cy - middle) / factor};
  parallel_for(static_cast<std::size_t>(height), kRowsPerChunk, [&](const Chunk& rows) {
    for (int v = static_cast<int>(rows.begin); v < static_cast<int>(rows.end); ++v) {
      for (int u = 0; u < width; ++u) {
        view.depth.at(u, v) = measurement_of(frame.depth, u * factor, v * factor, factor);
        mean_color(frame.color, u * factor, v * factor, factor, view.color.pixel(u, v));
      }
    }
  });
  return view;
}

std::optional<ProjectedPoint> project_point(const Intrinsics& intrinsics, const Eigen::Vector3d& point) {
  if (!(point.z() > 0)) return std::nullopt;
  const Eigen::Vector2d pixel = intrinsics.project(point);
  if (!(pixel.x() > -1 && pixel.y() > -1 && pixel.x() < intrinsics.width && pixel.y() < intrinsics.height))
    return std::nullopt;
  const int u = nearest_pixel(pixel.x());
  const int v = nearest_pixel(pixel.y());
  if (u < 0 || v < 0 || u >= intrinsics.width || v >= intrinsics.height) return std::nullopt;
  return ProjectedPoint{u, v, point.z()};
}

} // namespace kinora::ingest
