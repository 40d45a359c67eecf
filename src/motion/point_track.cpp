#include "motion/point_track.h"

#include <algorithm>
#include <limits>

namespace kinora::motion {
namespace {

std::size_t nearest_to(const std::vector<Eigen::Vector3d>& positions, const Eigen::Vector3d& point) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double squared = (positions[i] - point).squaredNorm();
    if (squared < least) {
      least = squared;
      best = i;
    }
  }
  return best;
}

/// A point bound to a layer: by its canonical place, or to one node.
struct BoundPoint {
  Eigen::Vector3d canonical;
  std::size_t node = 0;
  bool to_node = false;
};

BoundPoint bind(const Motion& motion, const Warp& warp, std::size_t frame, const Eigen::Vector3d& point) {
  const auto canonical = warp.to_canonical(point);
  if (canonical) return {*canonical};
  const std::size_t node = nearest_to(warp.node_positions(), point);
  const std::size_t last = motion.deformations().size() - 1;
  const SE3 to_world = motion.deformations()[std::min(frame, last)].node_to_world[node].to_se3();
  return {to_world.inverse() * point, node, true};
}

Eigen::Vector3d position_of(const Motion& motion, const Warp& warp, std::size_t frame, const BoundPoint& bound_point) {
  std::size_t node = bound_point.node;
  if (!bound_point.to_node) {
    const auto position = warp.to_world(bound_point.canonical);
    if (position) return *position;
    node = nearest_to(motion.graph()->nodes(), bound_point.canonical);
  }
  const std::size_t last = motion.deformations().size() - 1;
  return motion.deformations()[std::min(frame, last)].node_to_world[node].to_se3() * bound_point.canonical;
}

} // namespace

std::vector<std::vector<Eigen::Vector3d>> track_points(const Motion& motion, std::size_t frame_count, std::size_t frame,
                                                       std::span<const Eigen::Vector3d> points) {
  const Warp seen = motion.warp(static_cast<double>(frame));
  std::vector<BoundPoint> bound_points;
  for (const Eigen::Vector3d& point : points) bound_points.push_back(bind(motion, seen, frame, point));
  std::vector<std::vector<Eigen::Vector3d>> tracks(points.size());
  for (std::size_t f = 0; f < frame_count; ++f) {
    const Warp warp = motion.warp(static_cast<double>(f));
    for (std::size_t i = 0; i < bound_points.size(); ++i)
      tracks[i].push_back(position_of(motion, warp, f, bound_points[i]));
  }
  return tracks;
}

std::vector<Eigen::Vector3d> track_point(const Motion& motion, std::size_t frame_count, std::size_t frame,
                                         const Eigen::Vector3d& point) {
  return track_points(motion, frame_count, frame, {&point, 1}).front();
}

} // namespace kinora::motion
