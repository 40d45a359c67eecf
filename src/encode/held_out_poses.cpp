#include "encode/held_out_poses.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "encode/pose_path.h"

namespace kinora::encode {
namespace {

using motion::Health;

/// Where one layer is in a frame, if it is there; still layers have neither poses nor nodes. A frame beside one at
/// which it is there has it too.
struct LayerState {
  SE3 pose = SE3::Identity();
  std::vector<DualQuaternion> nodes;
  std::vector<Eigen::Vector3d> joints;
  Health health = Health::kHeld;
  bool there = true;
};

/// A frame that is to be added.
struct AddedFrame {
  double time;
  int capture_frame;
  SE3 camera_to_world;
  std::vector<LayerState> layers;
};

/// The pose on the path, `pose_at` telling it of each frame.
template <class PoseAt> SE3 pose_on(const PathSupport& support, const PoseAt& pose_at) {
  std::vector<SE3> poses;
  for (const std::size_t frame : support.frames) poses.push_back(pose_at(frame));
  return pose_on_path(poses, support.weights);
}

std::vector<Eigen::Vector3d> joints_on(const PathSupport& support, const motion::JointPaths& joints) {
  std::vector<Eigen::Vector3d> positions(joints.names.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < support.frames.size(); ++i) {
    const std::vector<Eigen::Vector3d>& known = joints.positions[support.frames[i]];
    for (std::size_t j = 0; j < positions.size(); ++j) positions[j] += support.weights[i] * known[j];
  }
  return positions;
}

LayerState state_at(const clip::Layer& layer, const std::vector<double>& times, double time) {
  const motion::Motion& motion = layer.motion;
  LayerState state;
  const auto after = std::upper_bound(times.begin(), times.end(), time);
  const auto next = static_cast<double>(after - times.begin());
  state.there =
      (after != times.begin() && layer.presence.at(next - 1)) || (after != times.end() && layer.presence.at(next));
  if (motion.kind() == motion::MotionKind::kStill) return state;
  const auto tracked = [&](std::size_t frame) { return motion.health(frame) == Health::kTracked; };
  const PathSupport support = path_support(times, time, tracked);
  const auto lost = [&](std::size_t frame) { return motion.health(frame) == Health::kLost; };
  if (std::any_of(support.frames.begin(), support.frames.end(), lost)) state.health = Health::kLost;
  if (motion.kind() == motion::MotionKind::kRigid) {
    state.pose = pose_on(support, [&](std::size_t frame) { return motion.poses()[frame].canonical_to_world; });
  } else {
    for (std::size_t n = 0; n < motion.graph()->nodes().size(); ++n) {
      state.nodes.push_back(DualQuaternion::from(
          pose_on(support, [&](std::size_t frame) { return motion.deformations()[frame].node_to_world[n].to_se3(); })));
    }
  }
  if (layer.joints) state.joints = joints_on(support, *layer.joints);
  return state;
}

// How cameras were moved about then.
SE3 correction_at(const std::vector<SE3>& corrections, const clip::Clip& clip, double time) {
  if (corrections.empty()) return SE3::Identity();
  const PathSupport support = path_support(clip.times, time, [](std::size_t) { return true; });
  return pose_on(support, [&](std::size_t frame) { return corrections[frame]; });
}

SE3 camera_at(const clip::Clip& clip, double time) {
  if (clip.camera_to_world.size() == 1) return clip.camera_to_world.front();
  const PathSupport support = path_support(clip.times, time, [](std::size_t) { return true; });
  return pose_on(support, [&](std::size_t frame) { return clip.camera_to_world[frame]; });
}

/// The order of all frames: numbers below that of the old ones are old frames, the rest added ones.
std::vector<std::size_t> order_of(const std::vector<int>& old, const std::vector<AddedFrame>& added) {
  std::vector<int> numbers = old;
  for (const AddedFrame& frame : added) numbers.push_back(frame.capture_frame);
  std::vector<std::size_t> order(numbers.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return numbers[a] < numbers[b]; });
  return order;
}

/// Of all frames in their order: `old` has one for each old one, `make` makes those that are added.
template <class T, class Make>
std::vector<T> merged(const std::vector<std::size_t>& order, const std::vector<T>& old, const Make& make) {
  std::vector<T> all;
  all.reserve(order.size());
  for (const std::size_t k : order) {
    if (k < old.size()) {
      all.push_back(old[k]);
    } else {
      all.push_back(make(k - old.size()));
    }
  }
  return all;
}

motion::Motion with_frames(const motion::Motion& motion, std::size_t layer, const std::vector<std::size_t>& order,
                           const std::vector<AddedFrame>& added) {
  if (motion.kind() == motion::MotionKind::kStill) return motion;
  const auto state = [&](std::size_t k) -> const LayerState& { return added[k].layers[layer]; };
  if (motion.kind() == motion::MotionKind::kRigid) {
    return motion::Motion::rigid(merged(order, motion.poses(), [&](std::size_t k) {
      return motion::Motion::Pose{state(k).pose, state(k).health};
    }));
  }
  return motion::Motion::deforming(motion.graph(), merged(order, motion.deformations(), [&](std::size_t k) {
                                     return motion::Motion::Deformation{state(k).nodes, state(k).health};
                                   }));
}

/// A node is born in the same frame as before, which has another number.
motion::NodeBirths with_frames(const motion::NodeBirths& births, const std::vector<std::size_t>& order,
                               std::size_t old_count) {
  std::vector<std::uint32_t> number_of(old_count + 1, static_cast<std::uint32_t>(order.size()));
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (order[i] < old_count) number_of[order[i]] = static_cast<std::uint32_t>(i);
  }
  std::vector<std::uint32_t> frames = births.frames();
  for (std::uint32_t& frame : frames) {
    if (frame > 0) frame = number_of[frame];
  }
  return motion::NodeBirths(std::move(frames));
}

} // namespace

void add_held_out_frames(clip::Clip& clip, ingest::Capture& held_out,
                         const std::optional<std::vector<SE3>>& camera_corrections, Progress& progress) {
  std::vector<AddedFrame> added;
  while (const auto frame = held_out.next()) {
    progress.check();
    const double time = frame->time - clip.metadata.at("start_seconds").get<double>();
    const SE3 camera = camera_corrections
                           ? correction_at(*camera_corrections, clip, time) * frame->camera.camera_to_world
                           : camera_at(clip, time);
    AddedFrame& now = added.emplace_back(AddedFrame{time, frame->index, camera, {}});
    for (const clip::Layer& layer : clip.layers) now.layers.push_back(state_at(layer, clip.times, time));
    progress.advance(added.size(), "");
  }
  const std::vector<std::size_t> order = order_of(clip.capture_frames, added);
  for (std::size_t i = 0; i < clip.layers.size(); ++i) {
    clip::Layer& layer = clip.layers[i];
    layer.presence = motion::Presence::of_frames(merged(order, layer.presence.in_frames(clip.times.size()),
                                                        [&](std::size_t k) { return added[k].layers[i].there; }));
    layer.births = with_frames(layer.births, order, clip.times.size());
    layer.motion = with_frames(layer.motion, i, order, added);
    if (!layer.joints) continue;
    layer.joints->positions =
        merged(order, layer.joints->positions, [&](std::size_t k) { return added[k].layers[i].joints; });
  }
  clip.times = merged(order, clip.times, [&](std::size_t k) { return added[k].time; });
  clip.capture_frames = merged(order, clip.capture_frames, [&](std::size_t k) { return added[k].capture_frame; });
  if (clip.camera_to_world.size() > 1 || camera_corrections) {
    clip.camera_to_world = merged(order, clip.camera_to_world, [&](std::size_t k) { return added[k].camera_to_world; });
  }
  clip.held_out = merged(order, clip.held_out, [](std::size_t) { return true; });
}

} // namespace kinora::encode
