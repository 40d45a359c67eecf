#include "fields/view_agreement.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "fields/layer_points.h"
#include "fields/pixel_map.h"
#include "fields/surface_band.h"

namespace kinora::fields {
namespace {

/// What one frame shows.
class FrameImage {
public:
  FrameImage(const PixelStore& store, std::size_t frame)
      : frame_(store.frames()[frame]), map_(store, store.frames()[frame]) {}

  /// Whether all pixels about that of a world point see something behind it; nothing where it is not in the image.
  std::optional<bool> sees_through(const Eigen::Vector3d& world, int label) const {
    const Eigen::Vector3d p = frame_.camera.camera_to_world.inverse() * world;
    const Intrinsics& k = frame_.camera.intrinsics;
    if (!(p.z() > 0)) return std::nullopt;
    const double u = k.fx * p.x() / p.z() + k.cx + 0.5;
    const double v = k.fy * p.y() / p.z() + k.cy + 0.5;
    const auto depth = static_cast<float>(p.z());
    // The point itself may be off by the sensor's noise, which this camera may see from the side.
    const int reach = 1 + static_cast<int>(std::ceil(ingest::depth_sigma(p.z()) * k.fx / p.z()));
    if (!(u >= reach && v >= reach && u < k.width - reach && v < k.height - reach)) return std::nullopt;
    if (map_.at(static_cast<int>(u), static_cast<int>(v)) == nullptr) return std::nullopt;
    bool through = true;
    for (int y = static_cast<int>(v) - reach; y <= static_cast<int>(v) + reach; ++y) {
      for (int x = static_cast<int>(u) - reach; x <= static_cast<int>(u) + reach; ++x) {
        const StoredPixel* pixel = map_.at(x, y);
        through = through && (pixel == nullptr || depth + three_sigma(depth) < empty_before(*pixel, label));
      }
    }
    return through;
  }

private:
  static float empty_before(const StoredPixel& pixel, int label) {
    if (pixel.label != label) return empty_until(pixel);
    return pixel.depth > 0 ? pixel.depth - three_sigma(pixel.depth) : 0;
  }

  const StoredFrame& frame_;
  PixelMap map_;
};

} // namespace

ViewAgreement agreement_of_views(const PixelStore& pixels, int label, const tracking::Motion& motion) {
  constexpr std::size_t kPoints = 4096;
  constexpr std::size_t kCameras = 12;
  const std::vector<LayerPoint> points = measured_points(pixels, label, motion, kPoints);
  const std::size_t frames = pixels.frames().size();
  const std::size_t cameras = std::min(kCameras, frames);
  ViewAgreement agreement;
  std::size_t through = 0;
  for (std::size_t c = 0; c < cameras; ++c) {
    const std::size_t f = c * frames / cameras;
    const int time = pixels.frames()[f].frame;
    if (motion.health(static_cast<std::size_t>(time)) == tracking::Health::kLost) continue;
    const FrameImage image(pixels, f);
    const tracking::Warp warp = motion.warp(time);
    for (const LayerPoint& point : points) {
      const auto world = point.frame == f ? std::nullopt : warp.to_world(point.canonical);
      const auto sees_through = world ? image.sees_through(*world, label) : std::nullopt;
      if (!sees_through) continue;
      ++agreement.looks;
      through += *sees_through ? 1 : 0;
    }
  }
  if (agreement.looks > 0) {
    agreement.seen_through = static_cast<double>(through) / static_cast<double>(agreement.looks);
  }
  return agreement;
}

LossWeights weights_for(const ViewAgreement& agreement) {
  constexpr double kRough = 0.005; // from so many looks on, opaque silhouettes would grow
  constexpr double kDoubt = 0.001; // from so many on, space about them would not be emptied
  const auto trust = [&](double bound) {
    return static_cast<float>(agreement.looks == 0 ? 0 : std::max(0.0, 1 - agreement.seen_through / bound));
  };
  LossWeights weights;
  weights.opacity *= 1 + trust(kRough);
  weights.depth *= 1 + trust(kRough);
  weights.empty_rays /= 1 + trust(kDoubt);
  return weights;
}

} // namespace kinora::fields
