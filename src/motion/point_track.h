// Where a material point of a layer is at every frame.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "motion/motion.h"

namespace kinora::motion {

/// The places (world, metres) of the point that is at `point` at frame `frame` (clamped to the clip), for frames
/// 0 … frame_count − 1. Never fails: where no node is near enough, the nearest node of that instant carries the point.
/// Thread-safe.
std::vector<Eigen::Vector3d> track_point(const Motion& motion, std::size_t frame_count, std::size_t frame,
                                         const Eigen::Vector3d& point);

/// The same for many points that are seen at the same frame: each frame's warp is made once. One row per point.
std::vector<std::vector<Eigen::Vector3d>> track_points(const Motion& motion, std::size_t frame_count, std::size_t frame,
                                                       std::span<const Eigen::Vector3d> points);

} // namespace kinora::motion
