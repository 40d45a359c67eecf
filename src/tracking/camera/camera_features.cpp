#include "tracking/camera/camera_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/random.h"
#include "core/sensor_noise.h"
#include "tracking/view/visibility.h"

namespace kinora::tracking {
namespace {

constexpr std::size_t kMaxFeatures = 128; // comparing all of two views takes about 0.2 ms
constexpr int kCell = 8;                  // view pixels: one feature in each at most
constexpr int kWindow = 2;                // view pixels about one that its gradients are summed over
constexpr float kMinCorner = 0.003F;      // (log luminance per pixel)², mean over the window: above the sensor's noise
constexpr double kMinFacing = 0.35;       // cosine: what is seen from 70° on is too coarse
constexpr float kMinContrast = 0.03F;     // of a piece, log luminance
constexpr double kMaxAxisCosine = 0.8;  // cosine: an axis nearer to the normal does not tell a direction on the surface
constexpr float kMinSimilarity = 0.8F;  // correlation of two descriptors
constexpr int kRansacIterations = 400;  // of three pairs
constexpr double kTolerance = 0.02;     // of the distance, that a feature may lie beside its like
constexpr std::size_t kMinPairs = 12;   // in agreement; by chance up to ten of fifty are
constexpr double kMinShare = 0.6;       // of the pairs that the pose lays where the other view has features
constexpr double kOverlapRadius = 0.05; // of the distance: so near to a feature is where a view has features

struct Corner {
  float strength;
  int u, v; ///< view pixels
};

// Smaller eigenvalue of the mean of the gradient's squares about a pixel.
float corner_strength(const LayerView& view, int level, int u, int v) {
  float xx = 0;
  float xy = 0;
  float yy = 0;
  for (int dv = -kWindow; dv <= kWindow; ++dv) {
    for (int du = -kWindow; du <= kWindow; ++du) {
      const float* g = view.pyramid[static_cast<std::size_t>(level)].values.pixel(u + du, v + dv);
      xx += g[1] * g[1];
      xy += g[1] * g[2];
      yy += g[2] * g[2];
    }
  }
  constexpr float kCount = (2 * kWindow + 1) * (2 * kWindow + 1);
  return (0.5F * (xx + yy) - std::sqrt(0.25F * (xx - yy) * (xx - yy) + xy * xy)) / kCount;
}

std::vector<Corner> find_corners(const LayerView& view) {
  int level = 0; // with a pixel to one of the view
  while (level + 1 < LayerView::kLevels && view.pyramid[static_cast<std::size_t>(level)].scale > 1) ++level;
  std::vector<Corner> corners;
  const Image<float>& values = view.pyramid[static_cast<std::size_t>(level)].values;
  const int width = std::min(view.intrinsics.width, values.width());
  const int height = std::min(view.intrinsics.height, values.height());
  for (int top = kWindow; top < height - kWindow; top += kCell) {
    for (int left = kWindow; left < width - kWindow; left += kCell) {
      Corner best{kMinCorner * kMinCorner, 0, 0};
      bool found = false;
      for (int v = top; v < std::min(top + kCell, height - kWindow); ++v) {
        for (int u = left; u < std::min(left + kCell, width - kWindow); ++u) {
          if (view.mask.at(u, v) != MaskArea::kInterior || view.planes.weights.at(u, v) <= 0) continue;
          const float strength = corner_strength(view, level, u, v);
          if (strength <= best.strength) continue;
          best = {strength, u, v};
          found = true;
        }
      }
      if (found) corners.push_back(best);
    }
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.strength > b.strength; });
  return corners;
}

// A direction on the surface that other views of it find too: the map's vertical, or its depth where that is the
// normal.
Eigen::Vector3d tangent_direction(const Eigen::Vector3d& normal, const Eigen::Matrix3d& camera_to_map) {
  const Eigen::Vector3d vertical = camera_to_map.row(1).transpose();
  const Eigen::Vector3d axis =
      std::abs(normal.dot(vertical)) < kMaxAxisCosine ? vertical : Eigen::Vector3d(camera_to_map.row(2).transpose());
  return (axis - normal.dot(axis) * normal).normalized();
}

using Descriptor = Eigen::Matrix<float, SurfaceFeatures::kSide * SurfaceFeatures::kSide, 1>;

// The texture about a point, on its plane; nothing if it leaves the picture or is plain.
std::optional<Descriptor> describe(const LayerView& view, const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                                   const Eigen::Matrix3d& camera_to_map, double size) {
  const double step = size / SurfaceFeatures::kSide;
  const Eigen::Vector3d along = step * tangent_direction(normal, camera_to_map);
  const Eigen::Vector3d across = normal.cross(along);
  const double pixels = view.intrinsics.fx * step / point.z(); // of the view from sample to sample
  int level = 0;
  while (level + 1 < LayerView::kLevels && view.pyramid[static_cast<std::size_t>(level)].scale * pixels > 1.5) ++level;
  Descriptor descriptor;
  Eigen::Index k = 0;
  for (int j = 0; j < SurfaceFeatures::kSide; ++j) {
    for (int i = 0; i < SurfaceFeatures::kSide; ++i) {
      constexpr double kMiddle = 0.5 * (SurfaceFeatures::kSide - 1);
      const Eigen::Vector3d sample = point + (i - kMiddle) * along + (j - kMiddle) * across;
      if (sample.z() < kNearestDepth) return std::nullopt;
      const Eigen::Vector2d pixel = view.intrinsics.project(sample);
      if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= view.intrinsics.width - 1 &&
            pixel.y() <= view.intrinsics.height - 1)) {
        return std::nullopt;
      }
      descriptor[k++] = view.sample_texture(level, pixel.x(), pixel.y()).value;
    }
  }
  descriptor.array() -= descriptor.mean();
  const float length = descriptor.norm();
  if (length < kMinContrast * SurfaceFeatures::kSide) return std::nullopt;
  return descriptor / length;
}

struct Pair {
  Eigen::Vector3d a, b;
  double tolerance; ///< metres
};

std::vector<Pair> mutual_matches(const SurfaceFeatures& a, const SurfaceFeatures& b) {
  std::vector<Pair> pairs;
  if (a.count() == 0 || b.count() == 0) return pairs;
  const Eigen::MatrixXf similarity = a.descriptors.transpose() * b.descriptors;
  std::vector<Eigen::Index> best_of_b(static_cast<std::size_t>(b.count()));
  for (Eigen::Index j = 0; j < b.count(); ++j) similarity.col(j).maxCoeff(&best_of_b[static_cast<std::size_t>(j)]);
  std::vector<Eigen::Index> best_of_a(static_cast<std::size_t>(a.count()), 0);
  for (Eigen::Index j = 1; j < b.count(); ++j) {
    for (Eigen::Index i = 0; i < a.count(); ++i) {
      Eigen::Index& best = best_of_a[static_cast<std::size_t>(i)];
      if (similarity(i, j) > similarity(i, best)) best = j;
    }
  }
  for (Eigen::Index j = 0; j < b.count(); ++j) {
    const Eigen::Index i = best_of_b[static_cast<std::size_t>(j)];
    if (best_of_a[static_cast<std::size_t>(i)] != j || similarity(i, j) < kMinSimilarity) continue;
    const Eigen::Vector3d p = a.positions.col(i).cast<double>();
    const Eigen::Vector3d q = b.positions.col(j).cast<double>();
    const double farther = std::max(p.z(), q.z());
    pairs.push_back({p, q, kTolerance * farther + 3 * kSensorNoise.sigma(farther)});
  }
  return pairs;
}

// Laid onto each other by least squares (Umeyama, 1991).
SE3 umeyama_pose(const std::vector<Pair>& pairs) {
  Eigen::Matrix3Xd from(3, static_cast<Eigen::Index>(pairs.size()));
  Eigen::Matrix3Xd to(3, static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = pairs[i].b;
    to.col(static_cast<Eigen::Index>(i)) = pairs[i].a;
  }
  return SE3(Eigen::umeyama(from, to, false));
}

// Three pairs tell a pose if their triangles are alike, and not too thin.
bool is_well_conditioned(const std::array<Pair, 3>& pairs) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Pair& p = pairs[i];
    const Pair& q = pairs[(i + 1) % 3];
    const double tolerance = p.tolerance + q.tolerance;
    const double side = (p.a - q.a).norm();
    if (side < 2 * tolerance || std::abs(side - (p.b - q.b).norm()) > tolerance) return false;
  }
  const Eigen::Vector3d side = pairs[1].a - pairs[0].a;
  const double height = side.cross(pairs[2].a - pairs[0].a).norm() / side.norm();
  return height > 2 * pairs[2].tolerance;
}

std::vector<Pair> inliers_of(const std::vector<Pair>& pairs, const SE3& b_to_a) {
  std::vector<Pair> result;
  for (const Pair& pair : pairs) {
    if ((b_to_a * pair.b - pair.a).norm() < pair.tolerance) result.push_back(pair);
  }
  return result;
}

// Pairs that should be like if b's features lie there.
std::size_t count_in_overlap(const std::vector<Pair>& pairs, const SurfaceFeatures& a, const SE3& b_to_a) {
  std::size_t count = 0;
  for (const Pair& pair : pairs) {
    const Eigen::Vector3f there = (b_to_a * pair.b).cast<float>();
    const auto near = static_cast<float>(kOverlapRadius * pair.b.z());
    if ((a.positions.colwise() - there).colwise().squaredNorm().minCoeff() < near * near) ++count;
  }
  return count;
}

} // namespace

SurfaceFeatures find_features(const LayerView& view, const Eigen::Matrix3d& camera_to_map, double size) {
  SurfaceFeatures features;
  if (view.empty()) return features;
  std::vector<Eigen::Vector3f> positions;
  std::vector<Descriptor> descriptors;
  for (const Corner& corner : find_corners(view)) {
    if (descriptors.size() == kMaxFeatures) break;
    const Eigen::Vector3d point = view.point(corner.u, corner.v);
    const float* plane = view.planes.planes.pixel(corner.u, corner.v);
    const Eigen::Vector3d normal(plane[0], plane[1], plane[2]);
    if (-normal.dot(point) < kMinFacing * point.norm()) continue;
    const auto descriptor = describe(view, point, normal, camera_to_map, size);
    if (!descriptor) continue;
    positions.push_back(point.cast<float>());
    descriptors.push_back(*descriptor);
  }
  features.positions.resize(3, static_cast<Eigen::Index>(descriptors.size()));
  features.descriptors.resize(Descriptor::RowsAtCompileTime, static_cast<Eigen::Index>(descriptors.size()));
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    features.positions.col(static_cast<Eigen::Index>(i)) = positions[i];
    features.descriptors.col(static_cast<Eigen::Index>(i)) = descriptors[i];
  }
  return features;
}

std::size_t count_matches(const SurfaceFeatures& a, const SurfaceFeatures& b) { return mutual_matches(a, b).size(); }

std::optional<SE3> register_by_features(const SurfaceFeatures& a, const SurfaceFeatures& b) {
  const std::vector<Pair> pairs = mutual_matches(a, b);
  if (pairs.size() < kMinPairs) return std::nullopt;
  Random random(pairs.size());
  const auto draw_match = [&] { return pairs[random.below(static_cast<std::uint32_t>(pairs.size()))]; };
  std::vector<Pair> best;
  for (int i = 0; i < kRansacIterations; ++i) {
    const std::array<Pair, 3> three = {draw_match(), draw_match(), draw_match()};
    if (!is_well_conditioned(three)) continue;
    std::vector<Pair> inliers = inliers_of(pairs, umeyama_pose({three.begin(), three.end()}));
    if (inliers.size() > best.size()) best = std::move(inliers);
  }
  const auto enough = [&](const SE3& b_to_a) {
    const auto overlapping = static_cast<double>(count_in_overlap(pairs, a, b_to_a));
    return best.size() >= kMinPairs && static_cast<double>(best.size()) >= kMinShare * overlapping;
  };
  for (int i = 0; i < 2; ++i) {
    if (best.size() < kMinPairs) return std::nullopt;
    const SE3 b_to_a = umeyama_pose(best);
    best = inliers_of(pairs, b_to_a);
    if (!enough(b_to_a)) return std::nullopt;
  }
  return renormalized(umeyama_pose(best));
}

} // namespace kinora::tracking
