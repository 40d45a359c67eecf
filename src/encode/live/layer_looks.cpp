#include "encode/live/layer_looks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace kinora::encode {
namespace {

constexpr int kSamplesAcross = 96; ///< of a picture: every such pixel is looked at

/// Calls visit(point in the camera) for some of the label's measured pixels.
template <class Visit> void for_some_pixels(const ingest::Frame& frame, int label, const Visit& visit) {
  const int step = std::max(1, frame.clean_depth.width() / kSamplesAcross);
  for (int v = step / 2; v < frame.clean_depth.height(); v += step) {
    for (int u = step / 2; u < frame.clean_depth.width(); u += step) {
      const float depth = frame.clean_depth.at(u, v);
      if (depth > 0 && frame.label_at(u, v) == label) visit(frame.camera.intrinsics.unproject(u, v, depth));
    }
  }
}

// A cell's three numbers side by side.
constexpr int kBits = 21;
constexpr std::int64_t kMiddle = 1LL << (kBits - 1);
constexpr std::uint64_t kMask = (1ULL << kBits) - 1;

std::uint64_t cell_at(const Eigen::Vector3d& canonical, double side) {
  std::uint64_t place = 0;
  for (int a = 0; a < 3; ++a) {
    const double cell = std::clamp(std::floor(canonical[a] / side), -1e6, 1e6);
    place = place << kBits | static_cast<std::uint64_t>(static_cast<std::int64_t>(cell) + kMiddle);
  }
  return place;
}

Eigen::Vector3d centre_of(std::uint64_t place, double side) {
  Eigen::Vector3d centre;
  for (int a = 2; a >= 0; --a, place >>= kBits) {
    centre[a] = side * (static_cast<double>(static_cast<std::int64_t>(place & kMask) - kMiddle) + 0.5);
  }
  return centre;
}

/// The looks of one place as one.
std::vector<Look> merged(std::vector<Look> looks) {
  std::ranges::stable_sort(looks, {}, &Look::place);
  std::vector<Look> out;
  for (const Look& look : looks) {
    if (out.empty() || out.back().place != look.place) {
      out.push_back(look);
    } else {
      out.back().towards_camera += look.towards_camera;
    }
  }
  for (Look& look : out) look.towards_camera.normalize();
  return out;
}

} // namespace

PlaceGrid PlaceGrid::of(const ingest::Frame& frame, int label) {
  constexpr double kCells = 16;
  Eigen::AlignedBox3d box;
  for_some_pixels(frame, label, [&](const Eigen::Vector3d& point) { box.extend(point); });
  return {box.isEmpty() ? 0 : std::max(box.sizes().maxCoeff() / kCells, 1e-3)};
}

std::vector<Look> looks_of(const ingest::Frame& frame, int label, const motion::Motion& motion, int timeline_index,
                           const PlaceGrid& grid) {
  std::vector<Look> looks;
  if (motion.health(static_cast<std::size_t>(timeline_index)) == motion::Health::kLost) return looks;
  const SE3& camera_to_world = frame.camera.camera_to_world;
  const motion::Warp warp = motion.warp(timeline_index);
  if (warp.is_rigid()) {
    if (!(grid.side > 0)) return looks;
    const SE3 camera_to_canonical = warp.rigid().inverse() * camera_to_world;
    for_some_pixels(frame, label, [&](const Eigen::Vector3d& point) {
      const Eigen::Vector3d towards = -(camera_to_canonical.linear() * point).normalized();
      looks.push_back({cell_at(camera_to_canonical * point, grid.side), towards.cast<float>()});
    });
    return merged(std::move(looks));
  }
  for_some_pixels(frame, label, [&](const Eigen::Vector3d& point) {
    std::array<motion::NearestPoints::Neighbour, 1> nearest;
    if (warp.nearest_nodes(camera_to_world * point, nearest) == 0) return;
    const auto node = static_cast<std::size_t>(nearest[0].index);
    const Eigen::Quaterniond turned = warp.node_to_world()[node].real;
    const Eigen::Vector3d towards = turned.conjugate() * -(camera_to_world.linear() * point).normalized();
    looks.push_back({node, towards.cast<float>()});
  });
  return merged(std::move(looks));
}

std::vector<Look> looks_from(const Eigen::Vector3d& camera_in_world, const std::vector<Look>& places,
                             const motion::Motion& motion, int timeline_index, const PlaceGrid& grid) {
  std::vector<Look> looks;
  looks.reserve(places.size());
  const motion::Warp warp = motion.warp(timeline_index);
  for (const Look& known : places) {
    Eigen::Vector3d towards = Eigen::Vector3d::Zero();
    if (warp.is_rigid()) {
      if (grid.side > 0) towards = warp.rigid().inverse() * camera_in_world - centre_of(known.place, grid.side);
    } else if (known.place < warp.node_positions().size()) {
      const Eigen::Quaterniond turned = warp.node_to_world()[known.place].real;
      towards = turned.conjugate() * (camera_in_world - warp.node_positions()[known.place]);
    }
    looks.push_back({known.place, towards.normalized().cast<float>()});
  }
  return looks;
}

double similarity(const std::vector<Look>& seen, const std::vector<Look>& wanted) {
  if (wanted.empty()) return 0;
  double sum = 0;
  auto at = seen.begin();
  for (const Look& look : wanted) {
    while (at != seen.end() && at->place < look.place) ++at;
    if (at == seen.end()) break;
    if (at->place != look.place) continue;
    const float cosine = std::max(0.0F, at->towards_camera.dot(look.towards_camera));
    sum += cosine * cosine;
  }
  return sum / static_cast<double>(wanted.size());
}

} // namespace kinora::encode
