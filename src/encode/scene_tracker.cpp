#include "encode/scene_tracker.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kinora::encode {
namespace {

constexpr std::size_t kMinPixelsToBegin = 100; ///< measured pixels that a label needs in its first frame
constexpr std::size_t kMaxLabels = 16;         ///< bound of memory and time for a damaged mask

} // namespace

struct SceneTracker::Sight {
  std::size_t pixels = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(); ///< of camera-frame points
  double squares = 0;                            ///< sum of their squared lengths
};

SceneTracker::SceneTracker(const ingest::CaptureInfo& capture, const TrackingSettings& settings, Progress& progress)
    : capture_(capture), settings_(settings), progress_(progress) {}

std::map<int, SceneTracker::Sight> SceneTracker::sights_in(const ingest::Frame& frame) const {
  std::array<Sight, 256> sights;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const float depth = frame.depth.at(u, v);
      if (!(depth > 0)) continue;
      Sight& sight = sights[frame.label_at(u, v)];
      const Eigen::Vector3d point = frame.camera.intrinsics.unproject(u, v, depth);
      ++sight.pixels;
      sight.sum += point;
      sight.squares += point.squaredNorm();
    }
  }
  std::map<int, Sight> seen;
  for (int label = 0; label < 256; ++label) {
    if (sights[static_cast<std::size_t>(label)].pixels > 0) seen[label] = sights[static_cast<std::size_t>(label)];
  }
  return seen;
}

void SceneTracker::begin_label(int label, const Sight& sight, const ingest::Frame& frame) {
  if (labels_.size() >= kMaxLabels) {
    if (!warned_of_crowd_) {
      progress_.warn(fmt::format("frame {} shows more than {} labels; label {} and others after it are not modelled",
                                 frame.index, kMaxLabels, label));
      warned_of_crowd_ = true;
    }
    return;
  }
  TrackedLabel& tracked = labels_[label];
  tracked.plan = plan_layer(label, capture_);
  tracked.first_frame = frames_;
  const Eigen::Vector3d mean = sight.sum / static_cast<double>(sight.pixels);
  tracked.centre = frame.camera.camera_to_world * mean;
  tracked.radius = std::sqrt(std::max(0.0, sight.squares / static_cast<double>(sight.pixels) - mean.squaredNorm()));
  if (tracked.plan.motion == motion::MotionKind::kStill) return;
  tracked.poses.assign(static_cast<std::size_t>(frames_), {SE3::Identity(), motion::Health::kLost});
  if (tracked.plan.motion == motion::MotionKind::kDeforming) {
    tracked.bending = std::make_unique<tracking::DeformingTracker>(label, settings_.deforming);
  } else {
    tracking::RigidTrackerConfig config = settings_.rigid;
    config.remembers |= !tracked.plan.is_told;
    tracked.tracker = std::make_unique<tracking::RigidTracker>(label, config);
  }
}

void SceneTracker::follow_rigid(TrackedLabel& tracked, const ingest::Frame& frame) {
  tracking::RigidTrackingResult result = tracked.tracker->track(frame);
  tracked.poses.push_back(result.pose);
  tracked.missed = std::move(result.missed);
  tracked.relocalised += result.relocalised ? 1 : 0;
  tracked.weak_directions += result.weak_directions;
  tracked.bend = tracked.tracker->bend();
  if (!tracked.bend) return;
  tracked.bend->first_frame += static_cast<std::size_t>(tracked.first_frame);
  if (!tracked.plan.is_told) let_bend(tracked);
}

void SceneTracker::let_bend(TrackedLabel& tracked) {
  tracking::DeformingTrackerConfig config = settings_.deforming;
  config.binding.use_body = false;
  tracked.bending = std::make_unique<tracking::DeformingTracker>(tracked.plan.label, config);
  const tracking::FrameMemory& memory = tracked.tracker->memory();
  for (std::size_t i = memory.begin(); i < memory.count(); ++i) tracked.bending->track(memory.at(i));
  // Places of the layer are those of the first frame that is remembered.
  const std::size_t before = static_cast<std::size_t>(tracked.first_frame) + memory.begin();
  const SE3 to_canonical = tracked.poses[before].canonical_to_world.inverse();
  tracked.poses.resize(before);
  for (auto& pose : tracked.poses) pose.canonical_to_world = pose.canonical_to_world * to_canonical;
  tracked.plan.motion = motion::MotionKind::kDeforming;
  tracked.tracker.reset();
}

void SceneTracker::add(const ingest::Frame& frame, StageTimes& times) {
  for (const auto& [label, sight] : sights_in(frame)) {
    if (!labels_.contains(label) && sight.pixels >= kMinPixelsToBegin) begin_label(label, sight, frame);
    if (const auto found = labels_.find(label); found != labels_.end()) found->second.pixels += sight.pixels;
  }
  std::vector<TrackedLabel*> layers;           // that bend as far as is known
  std::vector<tracking::NearbyObject> objects; // what hands may hold is followed first
  for (auto& [label, tracked] : labels_) {
    if (tracked.bending) layers.push_back(&tracked);
    if (!tracked.tracker) continue;
    times.measure("track " + tracked.plan.name, [&, &t = tracked] { follow_rigid(t, frame); });
    if (!tracked.tracker) continue; // it bends
    if (const auto object = tracking::nearby_object(*tracked.tracker)) objects.push_back(*object);
  }
  for (TrackedLabel* layer : layers) {
    times.measure("track " + layer->plan.name, [&] { layer->bending->track(frame, objects); });
  }
  for (auto& [label, tracked] : labels_) {
    if (!tracked.tracker || !tracked.missed) continue;
    for (const TrackedLabel* layer : layers) {
      const auto motion = layer->bending->carried(label);
      if (!motion) continue;
      tracked.tracker->carry(frame, std::move(*tracked.missed), *motion);
      tracked.poses.back() = tracked.tracker->poses().back();
      break;
    }
  }
  ++frames_;
}

std::map<int, TrackedLabel> SceneTracker::finish(StageTimes& times) && {
  for (auto& [label, tracked] : labels_) {
    if (!tracked.bending) continue;
    times.measure("settle " + tracked.plan.name, [&t = tracked] { t.layer = std::move(*t.bending).finish(); });
    tracked.bending.reset();
  }
  return std::move(labels_);
}

} // namespace kinora::encode
