#include "fields/sampling/warped_pixels.h"

#include <cmath>

#include "fields/sampling/parallel_append.h"
#include "fields/sampling/surface_band.h"
#include "motion/bulk_warp.h"

namespace kinora::fields {
namespace {

using motion::BulkWarp;

std::array<float, 3> to_array(const Eigen::Vector3d& v) {
  const Eigen::Vector3f single = v.cast<float>();
  return {single.x(), single.y(), single.z()};
}

Eigen::Vector3d to_vector(const std::array<float, 3>& v) { return Eigen::Vector3f(v.data()).cast<double>(); }

FieldRay relative_ray(const FieldBox& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                      double metres_per_depth) {
  return {to_array((origin - box.origin) / box.side), to_array(direction / box.side),
          static_cast<float>(metres_per_depth)};
}

} // namespace

LargeBuffer<WarpedPixel> warp_measured_pixels(const LayerObservations& layer, const FieldConfig& config,
                                              SensorNoise noise) {
  const PixelStore& pixels = layer.pixels;
  ParallelAppend<WarpedPixel> warped;
  const auto table = std::make_shared<const motion::InfluenceTable>(layer.motion.graph());
  for (const StoredFrame& frame : pixels.frames()) {
    if (layer.is_lost(frame)) continue;
    const BulkWarp warp(table, layer.motion.warp(frame.frame));
    const SE3& to_world = frame.camera.camera_to_world;
    const Eigen::Vector3d camera = to_world.translation() - warp.world_origin();
    warped.append(frame.end - frame.begin, [&](const Chunk& chunk, std::vector<WarpedPixel>& part) {
      std::vector<std::size_t> numbers;
      std::vector<BulkWarp::Ray> rays;
      for (std::size_t i = frame.begin + chunk.begin; i < frame.begin + chunk.end; ++i) {
        const StoredPixel& pixel = pixels.pixels()[i];
        if (!layer.is_foreground(pixel) || !pixel.depth.is_known()) continue;
        const float depth = pixel.depth.metres();
        const RowRay ray = frame.ray(pixel);
        const Eigen::Vector3d direction = to_world.linear() * ray.direction;
        const Eigen::Vector3d origin = camera + to_world.linear() * ray.origin;
        rays.push_back(
            {to_array(origin + depth * direction), to_array(direction), surface_band(config, depth, noise), 0});
        numbers.push_back(i);
      }
      std::vector<BulkWarp::CanonicalRay> canonical(rays.size());
      warp.to_canonical(rays, canonical.data());
      part.reserve(rays.size());
      for (std::size_t k = 0; k < rays.size(); ++k) {
        const BulkWarp::CanonicalRay& back = canonical[k];
        if (std::isnan(back.point[0])) continue;
        const Eigen::Vector3d direction = to_vector(back.direction);
        const double depth = pixels.pixels()[numbers[k]].depth.metres();
        const Eigen::Vector3d origin = to_vector(back.point) + warp.canonical_origin() - depth * direction;
        part.push_back({static_cast<std::uint32_t>(numbers[k]),
                        relative_ray(config.box, origin, direction, to_vector(rays[k].direction).norm()),
                        {to_array(to_vector(back.curvatures[0]) / config.box.side),
                         to_array(to_vector(back.curvatures[1]) / config.box.side)},
                        packed(back.rotation)});
      }
    });
  }
  return warped.joined();
}

} // namespace kinora::fields
