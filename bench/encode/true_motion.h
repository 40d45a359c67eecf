// What is known of the motion in a synthetic capture, in the place of what was tracked.
#pragma once

#include <cmath>
#include <vector>

#include "encode/frame_pass.h"
#include "evaluate/ground_truth.h"
#include "evaluate/ground_truth_tracks.h"

namespace kinora::bench {

/// Poses of a rigid thing as they truly were, if the truth has them.
inline void give_true_poses(const clip::Clip& clip, const std::map<int, SE3>& object_to_camera,
                            encode::TrackedLabel& label) {
  const auto first = object_to_camera.find(clip.capture_frames[static_cast<std::size_t>(label.first_frame)]);
  if (first == object_to_camera.end()) return;
  const SE3 world_of_first = clip.capture_camera(label.first_frame).camera_to_world * first->second;
  for (std::size_t i = 0; i < label.poses.size(); ++i) {
    const auto here = object_to_camera.find(clip.capture_frames[i]);
    if (here == object_to_camera.end()) continue;
    const SE3 world = clip.capture_camera(static_cast<double>(i)).camera_to_world * here->second;
    label.poses[i] = {world * world_of_first.inverse(), motion::Health::kTracked};
  }
}

/// The frame in which canonical space is the world: its nodes move least.
inline std::size_t canonical_frame(const motion::Motion& motion) {
  std::size_t best = 0;
  double least = 1e300;
  const auto& nodes = motion.graph()->nodes();
  for (std::size_t f = 0; f < motion.deformations().size(); ++f) {
    double sum = 0;
    for (std::size_t n = 0; n < nodes.size(); ++n)
      sum += (motion.deformations()[f].node_to_world[n].to_se3() * nodes[n] - nodes[n]).norm();
    if (sum < least) best = f;
    least = std::min(least, sum);
  }
  return best;
}

/// Each node moved by how far the points about it, seen or hidden, were from their true places. The tracks are a
/// hand's breadth apart, so what is finer stays as it was tracked.
inline motion::Motion corrected_by_tracks(const clip::Clip& clip, const evaluate::GroundTruthTracks& tracks,
                                          const motion::Motion& tracked) {
  constexpr double kReach = 0.06; // metres: standard deviation
  constexpr double kFree = 0.05;  // weight of no correction
  const std::size_t canonical = canonical_frame(tracked);
  const auto place = [&](const std::map<int, evaluate::TruePosition>& track,
                         std::size_t f) -> std::optional<Eigen::Vector3d> {
    const auto found = track.find(clip.capture_frames[f]);
    if (found == track.end()) return std::nullopt;
    return clip.capture_camera(static_cast<double>(f)).camera_to_world * found->second.point;
  };
  const auto& nodes = tracked.graph()->nodes();
  std::vector<motion::Motion::Deformation> deformations = tracked.deformations();
  for (std::size_t f = 0; f < deformations.size(); ++f) {
    const motion::Warp warp = tracked.warp(static_cast<double>(f));
    std::vector<Eigen::Vector3d> sums(nodes.size(), Eigen::Vector3d::Zero());
    std::vector<double> weights(nodes.size(), kFree);
    for (const auto& [id, track] : tracks) {
      const auto start = place(track, canonical);
      const auto truth = place(track, f);
      const auto found = start && truth ? warp.to_world(*start) : std::nullopt;
      if (!found) continue;
      for (std::size_t n = 0; n < nodes.size(); ++n) {
        const double weight = std::exp(-0.5 * (nodes[n] - *start).squaredNorm() / (kReach * kReach));
        sums[n] += weight * (*truth - *found);
        weights[n] += weight;
      }
    }
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const SE3 correction(Eigen::Translation3d(sums[n] / weights[n]));
      deformations[f].node_to_world[n] = DualQuaternion::from(correction * deformations[f].node_to_world[n].to_se3());
    }
  }
  return motion::Motion::deforming(tracked.graph(), std::move(deformations));
}

} // namespace kinora::bench
