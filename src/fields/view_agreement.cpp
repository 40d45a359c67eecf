#include "fields/view_agreement.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "fields/layer_points.h"
#include "fields/pixel_map.h"
#include "fields/surface_band.h"

namespace kinora::fields {
namespace {

constexpr double kDoubt = 0.001; // share of the looks from which on space about silhouettes has to be emptied

/// How a point meets what another frame shows.
struct Look {
  bool through = false; ///< all pixels about the point's see something behind it
  float before = 0;     ///< standard deviations of the sensor from the point to the layer's surface in its pixel, or 0
};

/// What one frame shows.
class FrameImage {
public:
  FrameImage(const PixelStore& store, std::size_t frame)
      : frame_(store.frames()[frame]), map_(store, store.frames()[frame]) {}

  /// Nothing where the world point is not in the image.
  std::optional<Look> look_at(const Eigen::Vector3d& world, int label) const {
    const Eigen::Vector3d p = frame_.camera.camera_to_world.inverse() * world;
    const Intrinsics& k = frame_.camera.intrinsics;
    if (!(p.z() > 0)) return std::nullopt;
    const double u = k.fx * p.x() / p.z() + k.cx + 0.5;
    const double v = k.fy * p.y() / p.z() + k.cy + 0.5;
    const auto depth = static_cast<float>(p.z());
    // The point itself may be off by the sensor's noise, which this camera may see from the side.
    const int reach = 1 + static_cast<int>(std::ceil(ingest::depth_sigma(p.z()) * k.fx / p.z()));
    if (!(u >= reach && v >= reach && u < k.width - reach && v < k.height - reach)) return std::nullopt;
    const StoredPixel* seen = map_.at(static_cast<int>(u), static_cast<int>(v));
    if (seen == nullptr) return std::nullopt;
    Look look{true, 0};
    if (seen->label == label) look.before = std::max(0.0F, 3 * (seen->depth - depth) / three_sigma(depth));
    for (int y = static_cast<int>(v) - reach; y <= static_cast<int>(v) + reach; ++y) {
      for (int x = static_cast<int>(u) - reach; x <= static_cast<int>(u) + reach; ++x) {
        const StoredPixel* pixel = map_.at(x, y);
        look.through = look.through && (pixel == nullptr || depth + three_sigma(depth) < empty_before(*pixel, label));
      }
    }
    return look;
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
  constexpr double kMedianOfDifference = 0.6745 * std::numbers::sqrt2; // of two normal errors' absolute difference
  const std::vector<LayerPoint> points = measured_points(pixels, label, motion, kPoints);
  const std::size_t frames = pixels.frames().size();
  const std::size_t cameras = std::min(kCameras, frames);
  ViewAgreement agreement;
  std::size_t through = 0;
  std::vector<float> before;
  for (std::size_t c = 0; c < cameras; ++c) {
    const std::size_t f = c * frames / cameras;
    const int time = pixels.frames()[f].frame;
    if (motion.health(static_cast<std::size_t>(time)) == tracking::Health::kLost) continue;
    const FrameImage image(pixels, f);
    const tracking::Warp warp = motion.warp(time);
    for (const LayerPoint& point : points) {
      const auto world = point.frame == f ? std::nullopt : warp.to_world(point.canonical);
      const auto look = world ? image.look_at(*world, label) : std::nullopt;
      if (!look) continue;
      ++agreement.looks;
      through += look->through ? 1 : 0;
      if (look->before > 0) before.push_back(look->before);
    }
  }
  if (agreement.looks > 0) {
    agreement.seen_through = static_cast<double>(through) / static_cast<double>(agreement.looks);
  }
  if (!before.empty()) {
    const auto middle = before.begin() + static_cast<std::ptrdiff_t>(before.size() / 2);
    std::nth_element(before.begin(), middle, before.end());
    agreement.noise = static_cast<double>(*middle) / kMedianOfDifference;
  }
  return agreement;
}

bool contradicts(const ViewAgreement& agreement) { return agreement.seen_through >= kDoubt; }

LossWeights weights_for(const ViewAgreement& agreement) {
  constexpr double kRough = 0.005; // from so many looks on, opaque silhouettes would grow
  constexpr double kMostNoise = 6; // beyond it bands would hold more than one surface
  const auto trust = [&](double bound) {
    return static_cast<float>(agreement.looks == 0 ? 0 : std::max(0.0, 1 - agreement.seen_through / bound));
  };
  LossWeights weights;
  weights.opacity *= 1 + trust(kRough);
  weights.depth *= 1 + trust(kRough);
  weights.empty_rays /= 1 + trust(kDoubt);
  weights.noise = static_cast<float>(std::clamp(agreement.noise, 1.0, kMostNoise));
  return weights;
}

} // namespace kinora::fields
