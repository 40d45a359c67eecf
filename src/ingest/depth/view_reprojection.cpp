#include "ingest/depth/view_reprojection.h"

#include "core/parallel.h"
#include "ingest/depth/registration.h"

namespace kinora::ingest {

ReducedView reproject(const Camera& camera, const ReducedView& view) {
  const SE3 to_view = view.camera_to_world.inverse() * camera.camera_to_world;
  const Intrinsics& k = camera.intrinsics;
  if (k == view.intrinsics && to_view.matrix() == SE3::Identity().matrix()) return view;
  ReducedView result{k, ColorImage(k.width, k.height, 3),
                     register_depth(view.depth, {view.intrinsics, k, to_view.inverse()}), camera.camera_to_world};
  constexpr std::size_t kRowsPerChunk = 16;
  parallel_for(static_cast<std::size_t>(k.height), kRowsPerChunk, [&](const Chunk& rows) {
    for (int v = static_cast<int>(rows.begin); v < static_cast<int>(rows.end); ++v) {
      for (int u = 0; u < k.width; ++u) {
        float& z = result.depth.at(u, v);
        const bool measured = z > 0;
        const Eigen::Vector3d ray = k.unproject(u, v, measured ? z : 1);
        const Eigen::Vector3d point =
            measured ? Eigen::Vector3d(to_view * ray) : Eigen::Vector3d(to_view.linear() * ray);
        if (!measured) z = kUnseen;
        if (!(point.z() > 0)) continue;
        const Eigen::Vector2d pixel = view.intrinsics.project(point);
        if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) continue;
        const int x = nearest_pixel(pixel.x());
        const int y = nearest_pixel(pixel.y());
        if (!view.depth.contains(x, y)) continue;
        if (!measured && view.depth.at(x, y) == 0) z = 0;
        std::copy_n(view.color.pixel(x, y), 3, result.color.pixel(u, v));
      }
    }
  });
  return result;
}

} // namespace kinora::ingest
