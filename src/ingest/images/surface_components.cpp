#include "ingest/images/surface_components.h"

#include <numeric>

#include "core/sensor_noise.h"

namespace kinora::ingest {
namespace {

/// Union-find over pixels; the root of a set is its least pixel.
class DisjointSets {
public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t root(std::int32_t i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      std::int32_t& parent = parent_[static_cast<std::size_t>(i)];
      parent = parent_[static_cast<std::size_t>(parent)];
      i = parent;
    }
    return i;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

private:
  std::vector<std::int32_t> parent_;
};

bool are_connected(float a, float b, int distance) {
  const double z = std::min(a, b);
  const double limit = std::max({0.025, 0.02 * z, kThreeSigmaOfDifference * kSensorNoise.sigma(z)});
  return std::abs(a - b) <= limit * (1 + 0.25 * (distance - 1));
}

} // namespace

int SurfaceComponents::largest() const {
  const auto most = std::max_element(
      list.begin(), list.end(), [](const SurfaceComponent& a, const SurfaceComponent& b) { return a.area < b.area; });
  return most == list.end() ? -1 : static_cast<int>(most - list.begin());
}

SurfaceComponents surface_components(const DepthImage& depth, const Mask& mask, const Intrinsics& intrinsics,
                                     int reach) {
  const int width = depth.width();
  const int height = depth.height();
  DisjointSets sets(depth.pixel_count());
  const auto in = [&](int u, int v) { return depth.at(u, v) > 0 && mask.at(u, v) != 0; };
  const auto link = [&](int u, int v, int du, int dv) {
    for (int step = 1; step <= reach && depth.contains(u + du * step, v + dv * step); ++step) {
      const int x = u + du * step;
      const int y = v + dv * step;
      if (depth.at(x, y) <= 0) continue;
      if (in(x, y) && are_connected(depth.at(u, v), depth.at(x, y), step)) sets.join(v * width + u, y * width + x);
      return;
    }
  };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (!in(u, v)) continue;
      link(u, v, 1, 0);
      link(u, v, 0, 1);
    }
  }
  SurfaceComponents result{Image<std::int32_t>(width, height, 1, -1), {}};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (!in(u, v)) continue;
      const std::int32_t root = sets.root(v * width + u);
      if (root == v * width + u) {
        result.map.at(u, v) = static_cast<std::int32_t>(result.list.size());
        result.list.emplace_back();
      }
      const std::int32_t number = result.map.data()[root];
      result.map.at(u, v) = number;
      SurfaceComponent& component = result.list[static_cast<std::size_t>(number)];
      const double z = depth.at(u, v);
      const Eigen::Vector3d point = intrinsics.unproject(u, v, z);
      ++component.pixels;
      component.area += z * z / (intrinsics.fx * intrinsics.fy);
      component.box.extend(point);
      component.centroid += point;
    }
  }
  for (SurfaceComponent& component : result.list) component.centroid /= static_cast<double>(component.pixels);
  return result;
}

} // namespace kinora::ingest
