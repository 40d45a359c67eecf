#include "fields/sampling/layer_points.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/parallel.h"
#include "motion/bulk_warp.h"

namespace kinora::fields {
namespace {

using motion::BulkWarp;

std::array<float, 3> to_array(const Eigen::Vector3d& v) {
  const Eigen::Vector3f single = v.cast<float>();
  return {single.x(), single.y(), single.z()};
}

constexpr float kReach = 0.01F; // metres; what the way back is like beside the point is not asked for

// Carries world points and ways to the camera back through a deformation; those without a way back are no numbers.
void warp_back(const BulkWarp& warp, std::vector<LayerPoint>& points, std::size_t first) {
  parallel_for(points.size() - first, 4096, [&](const Chunk& chunk) {
    std::vector<BulkWarp::Ray> rays;
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const LayerPoint& point = points[first + i];
      rays.push_back({to_array(point.canonical - warp.world_origin()), to_array(point.towards_camera), kReach, 0});
    }
    std::vector<BulkWarp::CanonicalRay> back(rays.size());
    warp.to_canonical(rays, back.data());
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const Eigen::Vector3f canonical(back[i - chunk.begin].point.data());
      points[first + i].canonical = canonical.cast<double>() + warp.canonical_origin();
      points[first + i].towards_camera =
          Eigen::Vector3f(back[i - chunk.begin].direction.data()).cast<double>().normalized();
    }
  });
}

/// Of the layer's pixels whose depth is wanted.
template <class IsWanted>
std::vector<LayerPoint> points_of(const LayerObservations& layer, std::size_t max_points, const IsWanted& is_wanted) {
  const PixelStore& store = layer.pixels;
  const motion::Motion& motion = layer.motion;
  const auto wanted = [&](const StoredPixel& pixel) { return layer.is_foreground(pixel) && is_wanted(pixel.depth); };
  const auto all = static_cast<std::size_t>(std::count_if(store.pixels().begin(), store.pixels().end(), wanted));
  const std::size_t stride = std::max<std::size_t>(1, all / max_points);
  std::shared_ptr<const motion::InfluenceTable> table;
  if (motion.graph() != nullptr) table = std::make_shared<const motion::InfluenceTable>(motion.graph());
  std::vector<LayerPoint> points;
  std::size_t found = 0;
  for (std::size_t f = 0; f < store.frames().size(); ++f) {
    const StoredFrame& frame = store.frames()[f];
    if (layer.is_lost(frame)) continue;
    const std::size_t first = points.size();
    const double kept = static_cast<double>(frame.end - frame.begin) /
                        (static_cast<double>(frame.camera.intrinsics.width) * frame.camera.intrinsics.height);
    for (std::size_t i = frame.begin; i < frame.end; ++i) {
      const StoredPixel& pixel = store.pixels()[i];
      if (!wanted(pixel) || found++ % stride != 0) continue;
      const Eigen::Vector3d in_camera = frame.camera.intrinsics.unproject(pixel.u, pixel.v, pixel.depth.metres());
      points.push_back({frame.camera.camera_to_world * in_camera,
                        frame.camera.camera_to_world.linear() * -in_camera.normalized(),
                        pixel.depth.metres() / frame.camera.intrinsics.fx, static_cast<double>(stride) / kept, f});
    }
    const motion::Warp warp = motion.warp(frame.frame);
    if (table != nullptr) {
      warp_back(BulkWarp(table, warp), points, first);
    } else {
      const SE3 world_to_canonical = warp.rigid().inverse();
      for (std::size_t i = first; i < points.size(); ++i) {
        points[i].canonical = world_to_canonical * points[i].canonical;
        points[i].towards_camera = world_to_canonical.linear() * points[i].towards_camera;
      }
    }
  }
  std::erase_if(points, [](const LayerPoint& point) { return !point.canonical.allFinite(); });
  return points;
}

} // namespace

std::vector<LayerPoint> measured_points(const LayerObservations& layer, std::size_t max_points) {
  return points_of(layer, max_points, [](StoredDepth depth) { return depth.is_measured(); });
}

std::vector<LayerPoint> measured_and_extended_points(const LayerObservations& layer, std::size_t max_points) {
  return points_of(layer, max_points, [](StoredDepth depth) { return depth.is_measured() || depth.is_extended(); });
}

} // namespace kinora::fields
