#include "bake/texture_charts.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <numeric>
#include <unordered_map>

#include <Eigen/Geometry>

namespace kinora::bake {
namespace {

constexpr double kMinCosine = 0.6;   ///< between a face and the chart's mean normal as it grows
constexpr double kLeastCosine = 0.2; ///< … and once it is grown
constexpr std::uint32_t kNone = 0xFFFFFFFFU;

struct FaceNormal {
  Eigen::Vector3d normal; // unit length
  double area;
};

std::vector<FaceNormal> face_normals(const Triangles& triangles) {
  std::vector<FaceNormal> normals;
  normals.reserve(triangles.faces.size());
  for (const auto& face : triangles.faces) {
    const Eigen::Vector3d& a = triangles.positions[face[0]];
    const Eigen::Vector3d across = (triangles.positions[face[1]] - a).cross(triangles.positions[face[2]] - a);
    const double length = across.norm();
    normals.push_back({length > 0 ? Eigen::Vector3d(across / length) : Eigen::Vector3d::UnitZ(), length / 2});
  }
  return normals;
}

/// The faces across the three edges of each; kNone where an edge has not exactly two faces.
std::vector<std::array<std::uint32_t, 3>> face_neighbours(const Triangles& triangles) {
  struct Side {
    std::uint64_t edge;
    std::uint32_t face;
    std::uint32_t side;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.faces.size());
  for (std::uint32_t f = 0; f < triangles.faces.size(); ++f) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint64_t a = triangles.faces[f][k];
      const std::uint64_t b = triangles.faces[f][(k + 1) % 3];
      sides.push_back({std::min(a, b) << 32 | std::max(a, b), f, k});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.edge, a.face, a.side) < std::tie(b.edge, b.face, b.side);
  });
  std::vector<std::array<std::uint32_t, 3>> neighbours(triangles.faces.size(), {kNone, kNone, kNone});
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].edge == sides[i].edge) ++end;
    if (end == i + 2) {
      neighbours[sides[i].face][sides[i].side] = sides[i + 1].face;
      neighbours[sides[i + 1].face][sides[i + 1].side] = sides[i].face;
    }
    i = end;
  }
  return neighbours;
}

/// Two unit vectors across `axis`, so that (right, up, axis) is right-handed.
std::array<Eigen::Vector3d, 2> plane_axes(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d away = std::abs(axis.x()) < 0.7 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d right = away.cross(axis).normalized();
  return {right, axis.cross(right)};
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Which pixels of a chart's plane are taken.
class TakenPixels {
public:
  explicit TakenPixels(double pixel) : pixel_(pixel) {}
  /// Takes the pixels whose centres lie in the triangle; false, and none taken, if another has one of them.
  bool take(const std::array<Eigen::Vector2d, 3>& corners) {
    constexpr double kInside = 1e-9; // a centre on an edge belongs to nobody
    const double area = cross(corners[1] - corners[0], corners[2] - corners[0]);
    found_.clear();
    const Eigen::Vector2d low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]) / pixel_;
    const Eigen::Vector2d high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]) / pixel_;
    for (auto y = std::lround(std::floor(low.y())); y <= std::lround(std::ceil(high.y())); ++y) {
      for (auto x = std::lround(std::floor(low.x())); x <= std::lround(std::ceil(high.x())); ++x) {
        const Eigen::Vector2d p = pixel_ * Eigen::Vector2d(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
        bool inside = true;
        for (std::size_t k = 0; k < 3 && inside; ++k)
          inside = cross(corners[(k + 1) % 3] - corners[k], p - corners[k]) > kInside * std::abs(area);
        if (!inside) continue;
        const auto key =
            static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32 | static_cast<std::uint32_t>(y);
        if (taken_.contains(key)) return false;
        found_.push_back(key);
      }
    }
    for (const std::uint64_t key : found_) taken_.emplace(key, true);
    return true;
  }

private:
  double pixel_;
  std::unordered_map<std::uint64_t, bool> taken_;
  std::vector<std::uint64_t> found_;
};

/// Turned so that the bounding box is small and lies, and moved to its lower corner.
void lay_down(Chart& chart) {
  constexpr int kAngles = 16;
  double least = std::numeric_limits<double>::infinity();
  Eigen::Matrix2d best = Eigen::Matrix2d::Identity();
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();
  for (int i = 0; i < 2 * kAngles; ++i) {
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(std::numbers::pi / (2 * kAngles) * i).toRotationMatrix();
    Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector2d high = -low;
    for (const auto& corners : chart.corners) {
      for (const Eigen::Vector2d& c : corners) {
        low = low.cwiseMin(turn * c);
        high = high.cwiseMax(turn * c);
      }
    }
    const Eigen::Vector2d size = high - low;
    if (size.x() < size.y() || !(size.prod() < least)) continue;
    least = size.prod();
    best = turn;
    corner = low;
    chart.size = size;
  }
  for (auto& corners : chart.corners) {
    for (Eigen::Vector2d& c : corners) c = best * c - corner;
  }
}

class ChartMaker {
public:
  ChartMaker(const Triangles& triangles, double pixel)
      : triangles_(triangles), pixel_(pixel), normals_(face_normals(triangles)),
        neighbours_(face_neighbours(triangles)), free_(triangles.faces.size(), 1),
        visited_(triangles.faces.size(), kNone) {}

  std::vector<Chart> run(const Progress& progress) {
    std::vector<std::uint32_t> seeds(triangles_.faces.size());
    std::iota(seeds.begin(), seeds.end(), 0U);
    std::stable_sort(seeds.begin(), seeds.end(),
                     [this](std::uint32_t a, std::uint32_t b) { return normals_[a].area > normals_[b].area; });
    for (const std::uint32_t seed : seeds) {
      // What a chart gives back may be reached by another, or is a seed itself later: the seed always stays.
      while (free_[seed] != 0) {
        progress.check();
        keep(grow(seed), seed);
      }
    }
    return std::move(charts_);
  }

private:
  struct Region {
    std::vector<std::uint32_t> faces;
    Eigen::Vector3d axis;
  };

  Region grow(std::uint32_t seed) {
    const auto round = static_cast<std::uint32_t>(charts_.size());
    Region region{{}, Eigen::Vector3d::Zero()};
    std::deque<std::uint32_t> queue{seed};
    visited_[seed] = round;
    Eigen::Vector3d sum = normals_[seed].normal * std::max(normals_[seed].area, 1e-12);
    while (!queue.empty()) {
      const std::uint32_t face = queue.front();
      queue.pop_front();
      if (face != seed && normals_[face].normal.dot(sum.normalized()) < kMinCosine) continue;
      region.faces.push_back(face);
      if (face != seed) sum += normals_[face].area * normals_[face].normal;
      for (const std::uint32_t next : neighbours_[face]) {
        if (next == kNone || free_[next] == 0 || visited_[next] == round) continue;
        visited_[next] = round;
        queue.push_back(next);
      }
    }
    region.axis = sum.normalized();
    if (normals_[seed].normal.dot(region.axis) < kLeastCosine) region = {{seed}, normals_[seed].normal};
    return region;
  }

  /// Of the region, the faces that lie flat beside one another.
  void keep(const Region& region, std::uint32_t seed) {
    const auto [right, up] = plane_axes(region.axis);
    TakenPixels taken(pixel_);
    Chart chart;
    for (const std::uint32_t face : region.faces) {
      if (normals_[face].normal.dot(region.axis) < kLeastCosine) continue;
      std::array<Eigen::Vector2d, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d& p = triangles_.positions[triangles_.faces[face][k]];
        corners[k] = {right.dot(p), up.dot(p)};
      }
      if (!taken.take(corners) && face != seed) continue;
      chart.faces.push_back(face);
      chart.corners.push_back(corners);
      free_[face] = 0;
    }
    lay_down(chart);
    charts_.push_back(std::move(chart));
  }

  const Triangles& triangles_;
  double pixel_;
  std::vector<FaceNormal> normals_;
  std::vector<std::array<std::uint32_t, 3>> neighbours_;
  std::vector<std::uint8_t> free_;     // in no chart yet
  std::vector<std::uint32_t> visited_; // by the growing of which chart
  std::vector<Chart> charts_;
};

} // namespace

std::vector<Chart> texture_charts(const Triangles& triangles, double pixel, const Progress& progress) {
  return ChartMaker(triangles, pixel).run(progress);
}

} // namespace kinora::bake
