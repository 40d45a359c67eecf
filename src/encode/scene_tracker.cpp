#include "encode/scene_tracker.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "ingest/frame/reduced_frame.h"

namespace kinora::encode {
namespace {

constexpr std::size_t kMinPixelsToBegin = 100; ///< measured pixels that a label needs in its first frame
/// Pixels along the longer side, about, that frames keep where things are followed. What sensors measure is no finer,
/// and noise of depth is told apart from shape in neighbourhoods of so many pixels.
constexpr double kLongSide = 640;
constexpr std::size_t kMaxLabels = 16; ///< bound of memory and time for a damaged mask

} // namespace

struct SceneTracker::LabelObservation {
  bool shown = false;                            ///< by a pixel, measured or not
  std::size_t pixels = 0;                        ///< measured
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(); ///< of camera-frame points
  double squares = 0;                            ///< sum of their squared lengths
};

SceneTracker::SceneTracker(const ingest::CaptureInfo& capture, const TrackingSettings& settings, Progress& progress)
    : capture_(capture), settings_(settings), progress_(progress) {}

std::map<int, SceneTracker::LabelObservation> SceneTracker::observations_in(const ingest::Frame& frame) const {
  std::array<LabelObservation, 256> observations;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      LabelObservation& observation = observations[frame.label_at(u, v)];
      observation.shown = true;
      const float depth = frame.depth.at(u, v);
      if (!(depth > 0)) continue;
      const Eigen::Vector3d point = frame.camera.intrinsics.unproject(u, v, depth);
      ++observation.pixels;
      observation.sum += point;
      observation.squares += point.squaredNorm();
    }
  }
  std::map<int, LabelObservation> seen;
  for (int label = 0; label < 256; ++label) {
    if (observations[static_cast<std::size_t>(label)].shown)
      seen[label] = observations[static_cast<std::size_t>(label)];
  }
  return seen;
}

void SceneTracker::begin_label(int label, const LabelObservation& observation, const ingest::Frame& frame) {
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
  tracked.first_shown = first_shown_.at(label);
  const Eigen::Vector3d mean = observation.sum / static_cast<double>(observation.pixels);
  tracked.centre = frame.camera.camera_to_world * mean;
  tracked.radius =
      std::sqrt(std::max(0.0, observation.squares / static_cast<double>(observation.pixels) - mean.squaredNorm()));
  if (tracked.plan.motion == motion::MotionKind::kStill) return;
  tracked.poses.assign(static_cast<std::size_t>(frames_), {SE3::Identity(), motion::Health::kLost});
  if (tracked.plan.motion == motion::MotionKind::kDeforming) {
    tracked.deforming_tracker = std::make_unique<tracking::DeformingTracker>(label, settings_.deforming);
  } else {
    tracking::RigidTrackerConfig config = settings_.rigid;
    config.keeps_history |= !tracked.plan.is_specified;
    tracked.tracker = std::make_unique<tracking::RigidTracker>(label, config);
  }
}

void SceneTracker::follow_rigid(TrackedLabel& tracked, const ingest::Frame& frame) {
  tracking::RigidTrackingResult result = tracked.tracker->track(frame);
  tracked.poses.push_back(result.pose);
  tracked.missed = std::move(result.missed);
  tracked.relocalised += result.relocalised ? 1 : 0;
  tracked.degenerate_directions += result.degenerate_directions;
  tracked.non_rigidity = tracked.tracker->non_rigidity();
  if (!tracked.non_rigidity) return;
  tracked.non_rigidity->first_frame += static_cast<std::size_t>(tracked.first_frame);
  if (!tracked.plan.is_specified) make_deforming(tracked);
}

void SceneTracker::make_deforming(TrackedLabel& tracked) {
  tracking::DeformingTrackerConfig config = settings_.deforming;
  config.binding.use_body = false;
  tracked.deforming_tracker = std::make_unique<tracking::DeformingTracker>(tracked.plan.label, config);
  const tracking::FrameHistory& history = tracked.tracker->history();
  for (std::size_t i = history.begin(); i < history.count(); ++i) tracked.deforming_tracker->track(history.at(i));
  // Places of the layer are those of the first frame that is remembered.
  const std::size_t before = static_cast<std::size_t>(tracked.first_frame) + history.begin();
  const SE3 to_canonical = tracked.poses[before].canonical_to_world.inverse();
  tracked.poses.resize(before);
  for (auto& pose : tracked.poses) pose.canonical_to_world = pose.canonical_to_world * to_canonical;
  tracked.plan.motion = motion::MotionKind::kDeforming;
  tracked.tracker.reset();
}

void SceneTracker::add(const ingest::Frame& full, StageTimes& times) {
  const int long_side = std::max(full.depth.width(), full.depth.height());
  const int factor = std::max(1, static_cast<int>(std::lround(long_side / kLongSide)));
  ingest::Frame fewer;
  if (factor > 1) fewer = ingest::reduced_frame(full, factor);
  const ingest::Frame& frame = factor > 1 ? fewer : full;
  for (const auto& [label, observation] : observations_in(full)) {
    first_shown_.try_emplace(label, static_cast<std::size_t>(frames_));
    if (!labels_.contains(label) && observation.pixels >= kMinPixelsToBegin) begin_label(label, observation, frame);
    if (const auto found = labels_.find(label); found != labels_.end()) {
      found->second.pixels += observation.pixels;
      found->second.last_shown = static_cast<std::size_t>(frames_);
    }
  }
  std::vector<TrackedLabel*> layers;           // that bend as far as is known
  std::vector<tracking::NearbyObject> objects; // what hands may hold is followed first
  for (auto& [label, tracked] : labels_) {
    if (tracked.deforming_tracker) layers.push_back(&tracked);
    if (!tracked.tracker) continue;
    times.measure("track " + tracked.plan.name, [&, &t = tracked] { follow_rigid(t, frame); });
    if (!tracked.tracker) continue; // it bends
    if (const auto object = tracking::nearby_object(*tracked.tracker)) objects.push_back(*object);
  }
  for (TrackedLabel* layer : layers) {
    times.measure("track " + layer->plan.name, [&] { layer->deforming_tracker->track(frame, objects); });
  }
  for (auto& [label, tracked] : labels_) {
    if (!tracked.tracker || !tracked.missed) continue;
    for (const TrackedLabel* layer : layers) {
      const auto motion = layer->deforming_tracker->contact_motion_of(label);
      if (!motion) continue;
      tracked.tracker->move_with_contact(frame, std::move(*tracked.missed), *motion);
      tracked.poses.back() = tracked.tracker->poses().back();
      break;
    }
  }
  ++frames_;
}

std::map<int, TrackedLabel> SceneTracker::finish(StageTimes& times) && {
  for (auto& [label, tracked] : labels_) {
    if (!tracked.deforming_tracker) continue;
    times.measure("settle " + tracked.plan.name,
                  [&t = tracked] { t.layer = std::move(*t.deforming_tracker).finish(); });
    tracked.deforming_tracker.reset();
  }
  return std::move(labels_);
}

} // namespace kinora::encode
