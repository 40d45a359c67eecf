#include "ingest/segmentation/flat_faces.h"

#include <optional>

#include <Eigen/Eigenvalues>

#include "ingest/frame/reduced_view.h"
#include "ingest/images/plane_finder.h"

namespace kinora::ingest {
namespace {

constexpr int kSeedStep = 5;
constexpr int kSeedRadius = 4;
constexpr double kSeedFlatness = 1.3; ///< standard deviations of the sensor: a seed's residual
constexpr double kReach = 2.2;        ///< standard deviations: a pixel lies on a face
constexpr int kRefits = 3;
constexpr double kStep = 0.025; ///< metres: beyond a free rim the scene lies farther away than this

struct Pixel {
  int u, v;
};

struct PlaneFit {
  Plane plane;
  double residual; ///< root mean square, metres
};

/// Sums for a least-squares plane.
class Moments {
public:
  void add(const Eigen::Vector3d& point) {
    sum_ += point;
    squares_ += point * point.transpose();
    ++count_;
  }
  double count() const { return count_; }
  PlaneFit fit() const {
    const Eigen::Vector3d mean = sum_ / count_;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(squares_ / count_ - mean * mean.transpose());
    const Eigen::Vector3d normal = axes.eigenvectors().col(0);
    const double offset = normal.dot(mean);
    return {offset <= 0 ? Plane{normal, offset} : Plane{-normal, -offset},
            std::sqrt(std::max(0.0, axes.eigenvalues()[0]))};
  }

private:
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares_ = Eigen::Matrix3d::Zero();
  double count_ = 0;
};

class FaceFinder {
public:
  FaceFinder(const DepthImage& depth, const Mask& foreground, const Intrinsics& intrinsics,
             const FlatFaceSearch& search)
      : depth_(depth), foreground_(foreground), intrinsics_(intrinsics), search_(search),
        taken_(depth.width(), depth.height(), 1, 0) {}

  Mask run() {
    Mask faces(depth_.width(), depth_.height());
    for (int v = kSeedRadius; v + kSeedRadius < depth_.height(); v += kSeedStep) {
      for (int u = kSeedRadius; u + kSeedRadius < depth_.width(); u += kSeedStep) {
        if (!usable(u, v) || taken_.at(u, v) != 0) continue;
        const std::optional<Plane> seed = seed_plane(u, v);
        if (!seed) continue;
        const std::vector<Pixel> face = grow(u, v, *seed);
        for (const Pixel& p : face) taken_.at(p.u, p.v) = 1;
        if (!is_face(face)) continue;
        for (const Pixel& p : face) faces.at(p.u, p.v) = 1;
      }
    }
    return faces;
  }

private:
  bool usable(int u, int v) const { return depth_.contains(u, v) && depth_.at(u, v) > 0 && foreground_.at(u, v) != 0; }
  Eigen::Vector3d point(int u, int v) const { return intrinsics_.unproject(u, v, depth_.at(u, v)); }

  std::optional<Plane> seed_plane(int u, int v) const {
    Moments moments;
    const float z = depth_.at(u, v);
    for (int y = v - kSeedRadius; y <= v + kSeedRadius; ++y)
      for (int x = u - kSeedRadius; x <= u + kSeedRadius; ++x)
        if (usable(x, y) && std::abs(depth_.at(x, y) - z) < 0.08) moments.add(point(x, y));
    constexpr int kSide = 2 * kSeedRadius + 1;
    if (moments.count() < 0.8 * kSide * kSide) return std::nullopt;
    const PlaneFit fit = moments.fit();
    if (fit.residual > kSeedFlatness * kSensorNoise.sigma(z)) return std::nullopt;
    return fit.plane;
  }

  /// Flood fill over what lies on the plane, which is fitted again to what was found.
  std::vector<Pixel> grow(int u, int v, Plane plane) const {
    std::vector<Pixel> face;
    for (int round = 0; round < kRefits; ++round) {
      Mask seen(depth_.width(), depth_.height());
      face.assign(1, {u, v});
      seen.at(u, v) = 1;
      Moments moments;
      for (std::size_t next = 0; next < face.size(); ++next) {
        const Pixel p = face[next];
        moments.add(point(p.u, p.v));
        for (const Pixel& q : {Pixel{p.u - 1, p.v}, Pixel{p.u + 1, p.v}, Pixel{p.u, p.v - 1}, Pixel{p.u, p.v + 1}}) {
          if (!usable(q.u, q.v) || seen.at(q.u, q.v) != 0 || taken_.at(q.u, q.v) != 0) continue;
          const Eigen::Vector3d at = point(q.u, q.v);
          // The noise lies along the ray.
          const double along = plane.distance(at) / std::max(0.2, std::abs(plane.normal.dot(at.normalized())));
          if (std::abs(along) > kReach * kSensorNoise.sigma(at.z())) continue;
          seen.at(q.u, q.v) = 1;
          face.push_back(q);
        }
      }
      if (moments.count() < 20) break;
      plane = moments.fit().plane;
    }
    return face;
  }

  bool is_face(const std::vector<Pixel>& face) const {
    double area = 0;
    Mask in(depth_.width(), depth_.height());
    double z = 0;
    for (const Pixel& p : face) {
      in.at(p.u, p.v) = 1;
      area += depth_.at(p.u, p.v) * depth_.at(p.u, p.v) / (intrinsics_.fx * intrinsics_.fy);
      z += depth_.at(p.u, p.v);
    }
    z /= static_cast<double>(face.size());
    if (area > search_.max_area || area < 3 * search_.min_radius * search_.min_radius) return false;
    if (inscribed_radius(in, face) * z / intrinsics_.fx < search_.min_radius) return false;
    return free_edge_share(in, face) >= search_.min_free_edge;
  }

  /// Pixels from the innermost pixel of a face to its rim (chamfer distance; small gaps are closed).
  static double inscribed_radius(const Mask& in, const std::vector<Pixel>& face) {
    int left = in.width(), right = 0, top = in.height(), bottom = 0;
    for (const Pixel& p : face) {
      left = std::min(left, p.u);
      right = std::max(right, p.u);
      top = std::min(top, p.v);
      bottom = std::max(bottom, p.v);
    }
    const int width = right - left + 3; // with a border of one pixel outside
    const int height = bottom - top + 3;
    const auto set = [&](int x, int y) {
      const int u = left + x - 1;
      const int v = top + y - 1;
      return in.contains(u, v) && in.at(u, v) != 0 ? 1 : 0;
    };
    Image<float> distance(width, height);
    for (int y = 1; y + 1 < height; ++y) {
      for (int x = 1; x + 1 < width; ++x) {
        int enclosing = 0;
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) enclosing += set(x + i, y + j);
        if (enclosing < 5) continue;
        distance.at(x, y) = std::min({distance.at(x - 1, y) + 1, distance.at(x, y - 1) + 1,
                                      distance.at(x - 1, y - 1) + 1.4F, distance.at(x + 1, y - 1) + 1.4F});
      }
    }
    float most = 0;
    for (int y = height - 2; y > 0; --y) {
      for (int x = width - 2; x > 0; --x) {
        if (distance.at(x, y) == 0) continue;
        distance.at(x, y) = std::min({distance.at(x, y), distance.at(x + 1, y) + 1, distance.at(x, y + 1) + 1,
                                      distance.at(x + 1, y + 1) + 1.4F, distance.at(x - 1, y + 1) + 1.4F});
        most = std::max(most, distance.at(x, y));
      }
    }
    return most;
  }

  /// Share of the rim beyond which, within two or three pixels, there is no foreground, or it lies clearly behind.
  double free_edge_share(const Mask& in, const std::vector<Pixel>& face) const {
    int boundary = 0;
    int free = 0;
    for (const Pixel& p : face) {
      for (const Pixel& step : {Pixel{-1, 0}, Pixel{1, 0}, Pixel{0, -1}, Pixel{0, 1}}) {
        const int u = p.u + step.u;
        const int v = p.v + step.v;
        if (!in.contains(u, v) || in.at(u, v) != 0) continue;
        const int x = p.u + 3 * step.u;
        const int y = p.v + 3 * step.v;
        if (in.contains(x, y) && in.at(x, y) != 0) continue; // a gap, not the rim
        ++boundary;
        if (!usable(x, y) || depth_.at(x, y) > depth_.at(p.u, p.v) + kStep) ++free;
      }
    }
    return boundary == 0 ? 0 : static_cast<double>(free) / boundary;
  }

  const DepthImage& depth_;
  const Mask& foreground_;
  const Intrinsics& intrinsics_;
  const FlatFaceSearch& search_;
  Mask taken_;
};

} // namespace

Mask flat_faces(const DepthImage& depth, const Mask& foreground, const Intrinsics& intrinsics,
                const FlatFaceSearch& search) {
  return FaceFinder(depth, foreground, intrinsics, search).run();
}

} // namespace kinora::ingest
