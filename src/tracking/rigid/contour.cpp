#include "tracking/rigid/contour.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tracking/view/silhouette.h"
#include "tracking/view/visibility.h"

namespace kinora::tracking {
namespace {

constexpr int kDepthRadius = 3;               // pixels, over which the depth at the border is taken
constexpr int kNormalRadius = 2;              // pixels, over which its direction is: handles are thin
constexpr DepthMargin kMargin{0.01, 2};       // what lies before the layer by more hides it
constexpr double kMinDirectionCosine = 0.707; // cosine
constexpr double kMaxSideways = 0.95;         // of a normal

bool is_border(const LabelImage& mask, int u, int v) {
  return mask.at(u, v) == MaskArea::kBorder && u > 0 && v > 0 && u + 1 < mask.width() && v + 1 < mask.height() &&
         (mask.at(u - 1, v) == 0 || mask.at(u + 1, v) == 0 || mask.at(u, v - 1) == 0 || mask.at(u, v + 1) == 0);
}

/// What lies around a pixel of the border.
struct BorderNeighbourhood {
  Eigen::Vector2d outward = Eigen::Vector2d::Zero();
  double nearest = 0; ///< measured depth beside the layer; 0: none
  double depth = 0;   ///< measured of the layer, mean; 0: none
  /// The nearest pixel of the layer with a plane, if there is one.
  int plane_u = 0, plane_v = 0;
  int plane_distance = std::numeric_limits<int>::max(); ///< squared
};

BorderNeighbourhood border_neighbourhood(const LayerView& view, int u, int v) {
  BorderNeighbourhood around;
  double sum = 0;
  double count = 0;
  for (int dv = -kDepthRadius; dv <= kDepthRadius; ++dv) {
    for (int du = -kDepthRadius; du <= kDepthRadius; ++du) {
      if (!view.mask.contains(u + du, v + dv)) continue;
      const double z = view.depth.at(u + du, v + dv);
      const bool is_near = std::max(std::abs(du), std::abs(dv)) <= kNormalRadius;
      if (view.mask.at(u + du, v + dv) == 0) {
        if (is_near) around.outward += Eigen::Vector2d(du, dv);
        if (z > 0 && (around.nearest == 0 || z < around.nearest)) around.nearest = z;
        continue;
      }
      if (is_near) around.outward -= Eigen::Vector2d(du, dv);
      const int distance = du * du + dv * dv;
      if (view.planes.weights.at(u + du, v + dv) > 0 && distance < around.plane_distance) {
        around.plane_u = u + du;
        around.plane_v = v + dv;
        around.plane_distance = distance;
      }
      if (z > 0) {
        sum += z;
        count += 1;
      }
    }
  }
  if (count > 0) around.depth = sum / count;
  return around;
}

// Planes end before the rim, and there a round shape falls away: as the circle that has the plane's normal and goes
// along the line of sight at the rim. A shape that ends in an edge is taken for deeper there, by the distance.
double depth_at_contour(const LayerView& view, const BorderNeighbourhood& around, const Eigen::Vector2d& outward) {
  if (around.plane_distance == std::numeric_limits<int>::max()) return around.depth;
  const double z = view.point(around.plane_u, around.plane_v).z();
  const float* plane = view.planes.planes.pixel(around.plane_u, around.plane_v);
  const double sideways = std::clamp(plane[0] * outward.x() + plane[1] * outward.y(), 0.0, kMaxSideways);
  const double distance = std::sqrt(around.plane_distance) * z / view.intrinsics.fx;
  return z + distance * std::sqrt(1 - sideways * sideways) / (1 - sideways);
}

template <class Each> void for_each_contour_pixel(const LayerView& view, const Each& each) {
  if (view.empty()) return;
  for (int v = 0; v < view.mask.height(); ++v) {
    for (int u = 0; u < view.mask.width(); ++u) {
      if (!is_border(view.mask, u, v)) continue;
      const BorderNeighbourhood around = border_neighbourhood(view, u, v);
      const double length = around.outward.norm();
      const bool is_hidden = is_occluded(around.depth, around.nearest, kMargin);
      if (around.depth <= 0 || length < 1 || is_hidden) continue;
      const Eigen::Vector2d outward = around.outward / length;
      each(u, v, depth_at_contour(view, around, outward), outward);
    }
  }
}

// Of pixels along the normal, by a step of the place.
Twist jacobian_along(const Eigen::Vector2d& normal, const Eigen::Vector3d& position, const LayerView& view,
                     const Pivot& pivot) {
  const double fx = view.intrinsics.fx / position.z() * normal.x();
  const double fy = view.intrinsics.fy / position.z() * normal.y();
  const Eigen::Vector3d gradient(fx, fy, -(fx * position.x() + fy * position.y()) / position.z());
  Twist jacobian;
  jacobian << gradient, (position - pivot.centre).cross(gradient) / pivot.radius;
  return jacobian;
}

} // namespace

std::vector<ContourPoint> contour_of(const LayerView& view) {
  std::vector<ContourPoint> points;
  for_each_contour_pixel(view, [&](int u, int v, double depth, const Eigen::Vector2d& normal) {
    points.push_back({view.intrinsics.unproject(u, v, depth), normal});
  });
  return points;
}

ContourMap::ContourMap(const LayerView& view) {
  LabelImage contour(view.mask.width(), view.mask.height());
  Image<float> points(view.mask.width(), view.mask.height(), 3);
  bool any = false;
  for_each_contour_pixel(view, [&](int u, int v, double depth, const Eigen::Vector2d& normal) {
    any = true;
    contour.at(u, v) = 1;
    float* point = points.pixel(u, v);
    point[0] = static_cast<float>(normal.x());
    point[1] = static_cast<float>(normal.y());
    point[2] = static_cast<float>(depth);
  });
  if (!any) return;
  offsets_ = offsets_to_silhouette(contour);
  points_ = std::move(points);
}

std::optional<ContourResidual> ContourMap::residual(const ContourPoint& moved, const LayerView& view,
                                                    const Pivot& pivot, double reach) const {
  const Eigen::Vector3d& p = moved.position;
  if (empty() || p.z() < kNearestDepth) return std::nullopt;
  const Eigen::Vector2d pixel = view.intrinsics.project(p);
  const auto u = static_cast<int>(std::floor(pixel.x() + 0.5));
  const auto v = static_cast<int>(std::floor(pixel.y() + 0.5));
  if (!offsets_.contains(u, v)) return std::nullopt;
  const std::int16_t* offset = offsets_.pixel(u, v);
  if (offset[0] * offset[0] + offset[1] * offset[1] > reach * reach) return std::nullopt;
  const Eigen::Vector2d nearest(u + offset[0], v + offset[1]);
  const float* there = points_.pixel(u + offset[0], v + offset[1]);
  const Eigen::Vector2d normal(there[0], there[1]);
  if (normal.dot(moved.normal) < kMinDirectionCosine) return std::nullopt;
  ContourResidual r;
  r.value = normal.dot(pixel - nearest);
  r.sigma = 1;
  r.jacobian = jacobian_along(normal, p, view, pivot);
  r.counterpart = jacobian_along(moved.normal, p * (there[2] / p.z()), view, pivot);
  return r;
}

} // namespace kinora::tracking
