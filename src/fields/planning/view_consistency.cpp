#include "fields/planning/view_consistency.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "fields/sampling/layer_points.h"
#include "fields/sampling/pixel_map.h"
#include "fields/sampling/surface_band.h"

namespace kinora::fields {
namespace {

constexpr double kMinInconsistent = 0.001; // share of the looks from which on space about silhouettes has to be emptied

/// How a point meets what another frame shows.
struct Observation {
  bool violates_free_space = false; ///< all pixels about the point's see something behind it
  float depth_residual =
      0; ///< standard deviations of the sensor from the point to the layer's surface in its pixel, or 0
};

/// What one frame shows.
class FrameImage {
public:
  FrameImage(const LayerObservations& layer, std::size_t frame)
      : layer_(layer), frame_(layer.pixels.frames()[frame]), map_(layer.pixels, frame_) {}

  /// Nothing where the world point is not in the image.
  std::optional<Observation> observe(const Eigen::Vector3d& world) const {
    const Eigen::Vector3d p = frame_.camera.camera_to_world.inverse() * world;
    const Intrinsics& k = frame_.camera.intrinsics;
    if (!(p.z() > 0)) return std::nullopt;
    const double u = k.fx * p.x() / p.z() + k.cx + 0.5;
    const double v = k.fy * p.y() / p.z() + k.cy + 0.5;
    const auto depth = static_cast<float>(p.z());
    // The point itself may be off by the sensor's noise, which this camera may see from the side.
    const int reach = 1 + static_cast<int>(std::ceil(kSensorNoise.sigma(p.z()) * k.fx / p.z()));
    if (!(u >= reach && v >= reach && u < k.width - reach && v < k.height - reach)) return std::nullopt;
    if (map_.at(static_cast<int>(u), static_cast<int>(v)) == nullptr) return std::nullopt;
    Observation observation{true, 0};
    if (const float seen = depth_between(u - 0.5, v - 0.5); seen > depth) {
      observation.depth_residual = 3 * (seen - depth) / kSensorNoise.three_sigma(depth);
    }
    for (int y = static_cast<int>(v) - reach; y <= static_cast<int>(v) + reach; ++y) {
      for (int x = static_cast<int>(u) - reach; x <= static_cast<int>(u) + reach; ++x) {
        const StoredPixel* pixel = map_.at(x, y);
        observation.violates_free_space =
            observation.violates_free_space &&
            (pixel == nullptr || depth + kSensorNoise.three_sigma(depth) < free_space_before(*pixel));
      }
    }
    return observation;
  }

private:
  /// Between the four pixels about a place, as of a plane through them; 0 unless all are the layer's and measured.
  float depth_between(double u, double v) const {
    const int left = static_cast<int>(u);
    const int top = static_cast<int>(v);
    double inverse = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const int x = left + corner % 2;
      const int y = top + corner / 2;
      const StoredPixel* pixel = map_.at(x, y);
      if (pixel == nullptr || !layer_.is_foreground(*pixel) || !pixel->depth.is_measured()) return 0;
      inverse += (1 - std::abs(u - x)) * (1 - std::abs(v - y)) / static_cast<double>(pixel->depth.metres());
    }
    return static_cast<float>(1 / inverse);
  }

  float free_space_before(const StoredPixel& pixel) const {
    if (!layer_.is_foreground(pixel)) return free_space_until(pixel);
    if (!pixel.depth.is_measured()) return 0;
    return pixel.depth.metres() - kSensorNoise.three_sigma(pixel.depth.metres());
  }

  LayerObservations layer_;
  const StoredFrame& frame_;
  PixelMap map_;
};

} // namespace

ViewConsistency measure_view_consistency(const LayerObservations& layer) {
  constexpr std::size_t kPoints = 4096;
  constexpr std::size_t kCameras = 12;
  // Of the absolute difference of two normal errors, one of them weighed between four pixels: Σ w² is 4/9 on average.
  const double median_of_difference = 0.6745 * std::sqrt(1 + 4.0 / 9);
  const std::vector<LayerPoint> points = measured_points(layer, kPoints);
  const std::size_t frames = layer.pixels.frames().size();
  const std::size_t cameras = std::min(kCameras, frames);
  ViewConsistency consistency;
  std::size_t violates_free_space = 0;
  std::vector<float> depth_residual;
  for (std::size_t c = 0; c < cameras; ++c) {
    const std::size_t f = c * frames / cameras;
    const StoredFrame& frame = layer.pixels.frames()[f];
    if (layer.is_lost(frame)) continue;
    const FrameImage image(layer, f);
    const motion::Warp warp = layer.motion.warp(frame.frame);
    for (const LayerPoint& point : points) {
      const auto world = point.frame == f ? std::nullopt : warp.to_world(point.canonical);
      const auto observation = world ? image.observe(*world) : std::nullopt;
      if (!observation) continue;
      ++consistency.observations;
      violates_free_space += observation->violates_free_space ? 1 : 0;
      if (observation->depth_residual > 0) depth_residual.push_back(observation->depth_residual);
    }
  }
  if (consistency.observations > 0) {
    consistency.free_space_violations =
        static_cast<double>(violates_free_space) / static_cast<double>(consistency.observations);
  }
  if (!depth_residual.empty()) {
    const auto middle = depth_residual.begin() + static_cast<std::ptrdiff_t>(depth_residual.size() / 2);
    std::nth_element(depth_residual.begin(), middle, depth_residual.end());
    consistency.noise = static_cast<double>(*middle) / median_of_difference;
  }
  return consistency;
}

LossWeights weights_for(const ViewConsistency& consistency, const LossWeights& usual) {
  constexpr double kMaxInconsistent = 0.005; // from so many looks on, opaque silhouettes would grow
  constexpr double kMaxNoise = 6;            // beyond it bands would hold more than one surface
  const auto consistency_within = [&](double bound) {
    return static_cast<float>(
        consistency.observations == 0 ? 0 : std::max(0.0, 1 - consistency.free_space_violations / bound));
  };
  LossWeights weights = usual;
  weights.opacity *= 1 + consistency_within(kMaxInconsistent);
  weights.depth *= 1 + consistency_within(kMaxInconsistent);
  weights.free_space_rays /= 1 + consistency_within(kMinInconsistent);
  weights.noise.scale = static_cast<float>(std::max<double>(usual.noise.scale, std::min(consistency.noise, kMaxNoise)));
  return weights;
}

void adapt_to(const ViewConsistency& consistency, const TrainerConfig& usual, TrainerConfig& trainer) {
  constexpr double kExact = 0.25; // standard deviations of the sensor: less than a quarter of a pixel's footprint
  const bool are_inconsistent = consistency.observations == 0 || consistency.free_space_violations >= kMinInconsistent;
  trainer.loss = weights_for(consistency, usual.loss);
  trainer.carve_free_space = usual.carve_free_space && are_inconsistent;
  trainer.exact_depth = usual.exact_depth || (!are_inconsistent && consistency.noise > 0 && consistency.noise < kExact);
}

} // namespace kinora::fields
