#include "encode/held_out_poses.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace kinora::encode {
namespace {

using motion::Health;

/// Where one layer is in a frame.
struct LayerState {
  motion::Warp warp;
  Health health;
};

/// A frame that is to be added.
struct AddedFrame {
  double time;
  int capture_frame;
  double position; ///< in the timeline without such frames
  SE3 camera_to_world;
  std::vector<LayerState> layers;
};

// Of the frames on both sides of a place in the timeline, the one that is known better.
Health health_at(const motion::Motion& motion, double position) {
  const Health before = motion.health(static_cast<std::size_t>(std::floor(position)));
  const Health after = motion.health(static_cast<std::size_t>(std::ceil(position)));
  return std::min(before, after);
}
static_assert(Health::kTracked < Health::kHeld && Health::kHeld < Health::kLost);

/// Finds out where things are, with the clip as it is.
class HeldOutPoses {
public:
  HeldOutPoses(const clip::Clip& clip, bool frames_know_camera, const std::map<std::string, LayerStiffness>& stiffness)
      : clip_(clip), frames_know_camera_(frames_know_camera), stiffness_(stiffness) {
    for (const clip::Layer& layer : clip_.layers) {
      drawables_.push_back(std::make_unique<fields::DrawableField>(layer.field, layer.motion.graph().get()));
    }
  }

  AddedFrame find(const ingest::Frame& frame) const {
    const double time = frame.time - clip_.metadata.at("start_seconds").get<double>();
    AddedFrame added{time, frame.index, clip_.frame_at(time), SE3::Identity(), {}};
    for (const clip::Layer& layer : clip_.layers) {
      added.layers.push_back({layer.motion.warp(added.position), health_at(layer.motion, added.position)});
    }
    Camera camera = clip_.capture_camera(added.position);
    const bool is_given = frames_know_camera_ || clip_.camera_to_world.size() == 1;
    if (frames_know_camera_) camera.camera_to_world = frame.camera.camera_to_world;
    if (!is_given) follow_camera(frame, added, camera);
    added.camera_to_world = camera.camera_to_world;
    follow_layers(frame, camera, added);
    return added;
  }

private:
  static constexpr std::uint8_t kNobody = 255;
  static constexpr float kExplained = 0.03F; // metres from what is drawn to what is measured

  std::vector<fields::Picture> draw(const AddedFrame& added, const Camera& camera) const {
    std::vector<fields::Picture> pictures;
    for (std::size_t i = 0; i < drawables_.size(); ++i) {
      if (added.layers[i].health == Health::kLost) {
        pictures.push_back(fields::render({}, camera, {.normals = true}));
        continue;
      }
      const fields::PosedField posed = fields::pose(*drawables_[i], added.layers[i].warp);
      pictures.push_back(fields::render({&posed, 1}, camera, {.normals = true}));
    }
    return pictures;
  }

  // Which layer's depth is nearest to what is measured, from 0; kNobody where none is near.
  static LabelImage nearest_layers(const std::vector<fields::Picture>& pictures, const DepthImage& measured) {
    LabelImage nearest(measured.width(), measured.height(), 1, kNobody);
    for (std::size_t p = 0; p < measured.pixel_count(); ++p) {
      float smallest = kExplained;
      for (std::size_t i = 0; i < pictures.size() && i < kNobody; ++i) {
        const float drawn = pictures[i].depth.values()[p];
        const float off = std::abs(drawn - measured.values()[p]);
        if (!(drawn > 0) || !(off < smallest)) continue;
        smallest = off;
        nearest.values()[p] = static_cast<std::uint8_t>(i);
      }
    }
    return nearest;
  }

  // The frame's depth where `layer` may be: what no other one explains better.
  static tracking::LayerView view_of(const ingest::Frame& frame, const Camera& camera, const LabelImage& nearest,
                                     std::size_t layer) {
    ingest::Frame shown;
    shown.index = frame.index;
    shown.time = frame.time;
    shown.camera = camera;
    shown.depth = frame.depth;
    shown.clean_depth = frame.clean_depth;
    shown.color = ColorImage(frame.depth.width(), frame.depth.height(), 3, 128);
    shown.labels = LabelImage(frame.depth.width(), frame.depth.height());
    for (std::size_t p = 0; p < shown.labels.pixel_count(); ++p) {
      const std::uint8_t owner = nearest.values()[p];
      const bool measured = frame.depth.values()[p] > 0;
      shown.labels.values()[p] = measured && (owner == layer || owner == kNobody) ? 1 : 0;
    }
    return tracking::view_label(shown, 1);
  }

  // By the first still layer: it moves before the camera as the camera does before it, the other way round.
  void follow_camera(const ingest::Frame& frame, const AddedFrame& added, Camera& camera) const {
    for (std::size_t i = 0; i < clip_.layers.size(); ++i) {
      if (clip_.layers[i].motion.kind() != motion::MotionKind::kStill) continue;
      const std::vector<fields::Picture> pictures = draw(added, camera);
      const auto view = view_of(frame, camera, nearest_layers(pictures, frame.depth), i);
      const auto found = align_by_depth(pictures[i], camera, added.layers[i].warp, {}, view);
      if (found) camera.camera_to_world = renormalized(found->rigid().inverse() * camera.camera_to_world);
      return;
    }
  }

  void follow_layers(const ingest::Frame& frame, const Camera& camera, AddedFrame& added) const {
    const std::vector<fields::Picture> pictures = draw(added, camera);
    const LabelImage nearest = nearest_layers(pictures, frame.depth);
    for (std::size_t i = 0; i < clip_.layers.size(); ++i) {
      LayerState& state = added.layers[i];
      if (clip_.layers[i].motion.kind() == motion::MotionKind::kStill || state.health == Health::kLost) continue;
      const auto known = stiffness_.find(clip_.layers[i].name);
      const auto found =
          align_by_depth(pictures[i], camera, state.warp, known == stiffness_.end() ? LayerStiffness{} : known->second,
                         view_of(frame, camera, nearest, i));
      state.health = found ? Health::kTracked : Health::kHeld;
      if (found) state.warp = *found;
    }
  }

  const clip::Clip& clip_;
  bool frames_know_camera_;
  const std::map<std::string, LayerStiffness>& stiffness_;
  std::vector<std::unique_ptr<fields::DrawableField>> drawables_;
};

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
      return motion::Motion::Pose{state(k).warp.rigid(), state(k).health};
    }));
  }
  return motion::Motion::deforming(motion.graph(), merged(order, motion.deformations(), [&](std::size_t k) {
                                     return motion::Motion::Deformation{state(k).warp.node_to_world(), state(k).health};
                                   }));
}

std::vector<Eigen::Vector3d> joints_at(const motion::JointPaths& joints, double position) {
  const auto before = static_cast<std::size_t>(std::floor(position));
  const auto after = static_cast<std::size_t>(std::ceil(position));
  const double share = position - std::floor(position);
  std::vector<Eigen::Vector3d> between = joints.positions[before];
  for (std::size_t j = 0; j < between.size(); ++j) {
    between[j] = (1 - share) * between[j] + share * joints.positions[after][j];
  }
  return between;
}

} // namespace

void add_held_out_frames(clip::Clip& clip, ingest::Capture& held_out, bool frames_know_camera,
                         const std::map<std::string, LayerStiffness>& stiffness, Progress& progress) {
  std::vector<AddedFrame> added;
  {
    const HeldOutPoses poses(clip, frames_know_camera, stiffness);
    while (const auto frame = held_out.next()) {
      progress.check();
      added.push_back(poses.find(*frame));
      progress.advance(added.size(), "");
    }
  }
  const std::vector<std::size_t> order = order_of(clip.capture_frames, added);
  for (std::size_t i = 0; i < clip.layers.size(); ++i) {
    clip::Layer& layer = clip.layers[i];
    layer.motion = with_frames(layer.motion, i, order, added);
    if (!layer.joints) continue;
    layer.joints->positions = merged(order, layer.joints->positions,
                                     [&](std::size_t k) { return joints_at(*layer.joints, added[k].position); });
  }
  clip.times = merged(order, clip.times, [&](std::size_t k) { return added[k].time; });
  clip.capture_frames = merged(order, clip.capture_frames, [&](std::size_t k) { return added[k].capture_frame; });
  if (clip.camera_to_world.size() > 1 || frames_know_camera) {
    clip.camera_to_world = merged(order, clip.camera_to_world, [&](std::size_t k) { return added[k].camera_to_world; });
  }
  clip.held_out = merged(order, clip.held_out, [](std::size_t) { return true; });
}

} // namespace kinora::encode
