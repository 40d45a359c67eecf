#include "tracking/rigid/pose_quality.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/statistics.h"

namespace kinora::tracking {
namespace {

constexpr double kMinSamples = 30;
constexpr int kSilhouetteMargin = 2; // pixels that a silhouette may be wrong by

// Beside the label, where the camera sees past it: what is measured there lies behind, or is background out of range.
bool violates_free_space(const ProjectedPoint& p, const LayerView& view) {
  if (view.to_silhouette.empty()) return false;
  const std::int16_t* offset = view.to_silhouette.pixel(p.pixel_u, p.pixel_v);
  if (offset[0] * offset[0] + offset[1] * offset[1] <= kSilhouetteMargin * kSilhouetteMargin) return false;
  const double z = p.point.z();
  const double measured = view.depth.at(p.pixel_u, p.pixel_v);
  return !(measured > 0) || kinora::violates_free_space(z, measured, kPoseMargin);
}

/// Pearson's correlation, from sums.
class Correlation {
public:
  void add(double a, double b) {
    n_ += 1;
    a_ += a;
    b_ += b;
    aa_ += a * a;
    bb_ += b * b;
    ab_ += a * b;
  }
  /// 0 with few samples, or if one side hardly varies.
  double value() const {
    if (n_ < kMinSamples) return 0;
    constexpr double kFloor = TextureModel::kMinTextureSigma * TextureModel::kMinTextureSigma;
    const double variance_a = aa_ / n_ - a_ * a_ / (n_ * n_);
    const double variance_b = bb_ / n_ - b_ * b_ / (n_ * n_);
    if (variance_a < kFloor || variance_b < kFloor) return 0;
    return (ab_ / n_ - a_ * b_ / (n_ * n_)) / std::sqrt(variance_a * variance_b);
  }

private:
  double n_ = 0, a_ = 0, b_ = 0, aa_ = 0, bb_ = 0, ab_ = 0;
};

/// The crop in cells, each large enough to hold several of the model's points if the model covers it.
class Coverage {
public:
  Coverage(const LayerView& view, std::size_t points)
      : view_(view),
        cell_(std::max(4, static_cast<int>(std::ceil(
                              std::sqrt(8.0 * static_cast<double>(view.depth_pixels) / static_cast<double>(points)))))),
        covered_((view.intrinsics.width + cell_ - 1) / cell_, (view.intrinsics.height + cell_ - 1) / cell_) {}

  void add(const ProjectedPoint& p) {
    const double z = p.point.z();
    const double measured = view_.point(p.pixel_u, p.pixel_v).z();
    if (std::abs(measured - z) < kPoseMargin.at(z)) {
      covered_.at(p.pixel_u / cell_, p.pixel_v / cell_) = 1;
    }
  }

  double share() const {
    double explained = 0;
    for (int v = 0; v < view_.intrinsics.height; ++v) {
      for (int u = 0; u < view_.intrinsics.width; ++u) {
        if (view_.planes.weights.at(u, v) > 0 && covered_.at(u / cell_, v / cell_) != 0) explained += 1;
      }
    }
    return explained / static_cast<double>(view_.depth_pixels);
  }

private:
  const LayerView& view_;
  int cell_;
  LabelImage covered_;
};

} // namespace

PoseQuality evaluate_pose(std::span<const ModelPoint> points, const LayerView& view, const SE3& model_to_camera) {
  PoseQuality quality;
  if (points.empty() || view.empty()) return quality;
  std::vector<double> distances;
  Correlation correlation;
  Coverage coverage(view, points.size());
  const TextureModel texture = measure_texture(points, view, model_to_camera, 0);
  for (const ModelPoint& point : points) {
    const auto p = project(point, view, model_to_camera);
    if (!p) continue;
    quality.free_space_violations += violates_free_space(*p, view) ? 1 : 0;
    if (view.planes.weights.at(p->pixel_u, p->pixel_v) > 0) {
      ++quality.on_label;
      coverage.add(*p);
      const auto r = geometric_residual(*p, view, Pivot(), kEvaluationGates);
      if (r && std::abs(r->value) < inlier_distance(r->sigma)) distances.push_back(std::abs(r->value));
    }
    if (const auto r = photometric_residual(*p, point, view, Pivot(), 0, texture.light)) {
      const double expected = point.texture[0];
      correlation.add(r->value + expected, expected);
    }
  }
  quality.inliers = distances.size();
  if (!distances.empty()) quality.median_distance = median(distances);
  quality.texture_correlation = correlation.value();
  quality.explained_share = coverage.share();
  return quality;
}

} // namespace kinora::tracking
