#include "ingest/images/plane_finder.h"

#include <optional>

#include <Eigen/Eigenvalues>

#include "core/random.h"
#include "ingest/frame/reduced_view.h"

namespace kinora::ingest {
namespace {

constexpr int kTrials = 300;
constexpr int kRefinements = 4;
constexpr int kNeighbourhood = 40; ///< pixels
constexpr std::size_t kScored = 3000;

using Points = std::vector<Eigen::Vector3d>;

Plane facing_camera(const Eigen::Vector3d& normal, double offset) {
  return offset <= 0 ? Plane{normal, offset} : Plane{-normal, -offset};
}

bool on_plane(const Plane& plane, const Eigen::Vector3d& point) {
  return std::abs(plane.distance(point)) <= same_surface_tolerance(point.z());
}

std::size_t count_on(const Plane& plane, const Points& points) {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(), [&](const Eigen::Vector3d& p) { return on_plane(plane, p); }));
}

struct Fit {
  Plane plane;
  double width; ///< metres: of the narrower side of a rectangle that spreads as the points do
};

/// Least squares through the points that lie on a plane already.
std::optional<Fit> refined(const Plane& plane, const Points& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double count = 0;
  for (const Eigen::Vector3d& point : points) {
    if (!on_plane(plane, point)) continue;
    sum += point;
    squares += point * point.transpose();
    ++count;
  }
  if (count < 3) return std::nullopt;
  const Eigen::Vector3d mean = sum / count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(squares / count - mean * mean.transpose());
  const Eigen::Vector3d normal = axes.eigenvectors().col(0);
  return Fit{facing_camera(normal, normal.dot(mean)), std::sqrt(12 * std::max(0.0, axes.eigenvalues()[1]))};
}

std::optional<Fit> best_plane(const DepthImage& depth, const Intrinsics& intrinsics, const Points& points,
                              const std::vector<std::size_t>& pixels, Random& random) {
  Points scored;
  const std::size_t step = std::max<std::size_t>(1, points.size() / kScored);
  for (std::size_t i = 0; i < points.size(); i += step) scored.push_back(points[i]);
  std::optional<Plane> best;
  std::size_t most = 0;
  const auto width = static_cast<std::size_t>(depth.width());
  for (int trial = 0; trial < kTrials; ++trial) {
    const std::size_t at = pixels[random.below(static_cast<std::uint32_t>(pixels.size()))];
    const int u = static_cast<int>(at % width);
    const int v = static_cast<int>(at / width);
    const auto nearby = [&]() -> std::optional<Eigen::Vector3d> {
      const int x = u + static_cast<int>(random.below(2 * kNeighbourhood + 1)) - kNeighbourhood;
      const int y = v + static_cast<int>(random.below(2 * kNeighbourhood + 1)) - kNeighbourhood;
      if (!depth.contains(x, y) || depth.at(x, y) <= 0) return std::nullopt;
      return intrinsics.unproject(x, y, depth.at(x, y));
    };
    const Eigen::Vector3d a = intrinsics.unproject(u, v, depth.at(u, v));
    const auto b = nearby();
    const auto c = nearby();
    if (!b || !c) continue;
    const Eigen::Vector3d normal = (*b - a).cross(*c - a);
    if (normal.norm() < 1e-4) continue;
    const Plane plane = facing_camera(normal.normalized(), normal.normalized().dot(a));
    const std::size_t count = count_on(plane, scored);
    if (count <= most) continue;
    most = count;
    best = plane;
  }
  std::optional<Fit> fit;
  for (int i = 0; best && i < kRefinements; ++i) {
    fit = refined(*best, points);
    if (fit) best = fit->plane;
  }
  return fit;
}

} // namespace

std::vector<Plane> find_planes(const DepthImage& depth, const Intrinsics& intrinsics, const PlaneSearch& search) {
  Points points;
  std::vector<std::size_t> pixels;
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      if (!(depth.at(u, v) > 0) || !std::isfinite(depth.at(u, v))) continue;
      points.push_back(intrinsics.unproject(u, v, depth.at(u, v)));
      pixels.push_back(static_cast<std::size_t>(v) * static_cast<std::size_t>(depth.width()) +
                       static_cast<std::size_t>(u));
    }
  }
  const double needed = search.min_share * static_cast<double>(points.size());
  Random random(search.seed);
  std::vector<Plane> planes;
  while (static_cast<int>(planes.size()) < search.max_planes && static_cast<double>(points.size()) >= needed &&
         points.size() >= 3) {
    const auto fit = best_plane(depth, intrinsics, points, pixels, random);
    if (!fit || static_cast<double>(count_on(fit->plane, points)) < needed) break;
    const Plane& plane = fit->plane;
    Eigen::AlignedBox3d box;
    double squares = 0;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (on_plane(plane, points[i])) {
        box.extend(points[i]);
        const double off = plane.distance(points[i]) / same_surface_tolerance(points[i].z());
        squares += off * off;
        continue;
      }
      points[kept] = points[i];
      pixels[kept++] = pixels[i];
    }
    const double roughness = std::sqrt(squares / static_cast<double>(points.size() - kept));
    points.resize(kept);
    pixels.resize(kept);
    const bool flat = roughness <= search.max_roughness || fit->width >= search.wide;
    if (box.diagonal().norm() >= search.min_extent && flat) planes.push_back(plane);
  }
  return planes;
}

} // namespace kinora::ingest
