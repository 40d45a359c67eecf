#include "tracking/camera/camera_tracker.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tracking/camera/background_view.h"
#include "tracking/camera/camera_stationarity.h"

namespace kinora::tracking {
CameraTrackingResult CameraTracker::track(const ingest::Frame& frame) {
  const BackgroundFrame reduced = reduce_background(frame);
  const LayerView view = view_background(reduced);
  CameraTrackingResult result;
  if (config_.frames_to_move == 0 && !moves()) moving_from_ = 0;
  if (!keyframes_.empty()) {
    follow(reduced, view, result);
  } else {
    relative_poses_.push_back({0, SE3::Identity()});
    if (view.depth_pixels >= config_.min_pixels) {
      add_keyframe(reduced, view, SE3::Identity());
    } else {
      result.health = motion::Health::kLost;
    }
  }
  last_time_ = reduced.time;
  times_.push_back(reduced.time);
  results_.push_back(result);
  return result;
}

// Where constant velocity, or a share of it, leads from the last place.
SE3 CameraTracker::extrapolated(double time, double share) const {
  const double step = std::clamp(time - last_time_, 0.0, config_.motion.max_extrapolation);
  return map_pose(relative_poses_.back()) * exp_se3(share * step * velocity_);
}

std::vector<std::size_t> CameraTracker::nearest_keyframes(const SE3& camera_to_map, std::size_t count) const {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    order.emplace_back(view_change(map_[k].inverse() * camera_to_map, keyframes_[k].distance), k);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> nearest;
  for (std::size_t i = 0; i < std::min(count, order.size()); ++i) nearest.push_back(order[i].second);
  return nearest;
}

// Of those that agree with the reference, which may not have met an older part of the map yet: itself and its
// neighbours, the nearest first.
std::vector<std::size_t> CameraTracker::references_for(const SE3& camera_to_map, std::size_t reference) const {
  std::vector<std::size_t> near = nearest_keyframes(camera_to_map, keyframes_.size());
  std::erase_if(near, [&](std::size_t k) {
    const std::vector<std::size_t>& known = neighbours_[reference];
    return k != reference && std::find(known.begin(), known.end(), k) == known.end();
  });
  near.resize(std::min(near.size(), config_.references));
  return near;
}

CameraFit CameraTracker::fit_near(const LayerView& view, const SE3& camera_to_map, std::size_t reference,
                                  int coarsest_level, RelativePose& found) const {
  const std::vector<std::size_t> references = references_for(camera_to_map, reference);
  const SE3& origin = map_[references.front()];
  std::vector<ModelPoint> points;
  for (std::size_t r = 0; r < references.size(); ++r) {
    const SE3 to_origin = origin.inverse() * map_[references[r]];
    const Eigen::Matrix3f rotation = to_origin.linear().cast<float>();
    const Eigen::Vector3f translation = to_origin.translation().cast<float>();
    const std::vector<ModelPoint>& keyframe_points = keyframes_[references[r]].points;
    const std::size_t share = config_.max_points / references.size();
    for (std::size_t k = 0; k < std::min(share, keyframe_points.size()); ++k) {
      ModelPoint point = keyframe_points[k * keyframe_points.size() / std::min(share, keyframe_points.size())];
      point.position = rotation * point.position + translation;
      point.normal = rotation * point.normal;
      point.direction = direction_of(point.normal);
      points.push_back(point);
    }
  }
  CameraFit fit = fit_camera(points, view, camera_to_map.inverse() * origin, coarsest_level);
  found = {references.front(), fit.pose().inverse()};
  return fit;
}

SurfaceFeatures CameraTracker::features_of(const LayerView& view, const SE3& camera_to_map) const {
  return find_features(view, camera_to_map.linear(), config_.relocalisation.feature_size * keyframes_.front().distance);
}

// By a hand, since a frame showed where it was.
bool CameraTracker::is_reachable(const SE3& camera_to_map, double time) const {
  const SE3 motion = map_pose(anchor_).inverse() * camera_to_map;
  const double since = std::max(0.0, time - anchor_time_);
  return rotation_angle(motion) < config_.relocalisation.same_pose + config_.motion.max_angular_velocity * since &&
         motion.translation().norm() < config_.relocalisation.same_pose * keyframes_[anchor_.keyframe].distance +
                                           config_.motion.max_velocity * since;
}

// Anywhere in the map, if it looks so there and nowhere else.
bool CameraTracker::relocalise_by_features(const LayerView& view, double time, const SE3& expected, CameraFit& fit,
                                           RelativePose& found) const {
  const SurfaceFeatures features = features_of(view, expected);
  std::vector<std::size_t> all(keyframes_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  bool any = false;
  for (const std::size_t k : most_similar(features, keyframes_, all, config_.relocalisation.keyframes)) {
    const auto start = register_by_features(keyframes_[k].features, features);
    if (!start) continue;
    RelativePose relative{};
    CameraFit fit_there = fit_near(view, map_[k] * *start, k, 2, relative);
    if (!fit_there.certain() || !is_reachable(map_pose(relative), time)) continue;
    if (any)
      return view_change(map_pose(found).inverse() * map_pose(relative), keyframes_[k].distance) <
             config_.relocalisation.same_pose;
    any = true;
    fit = std::move(fit_there);
    found = relative;
  }
  return any;
}

// At the place that is expected, else where it was last; if it has been lost, first where its features are known from.
CameraFit CameraTracker::find_pose(const LayerView& view, double time, const SE3& expected, RelativePose& found) {
  CameraFit best;
  if (gap_.is_open()) {
    uncertain_ = !relocalise_by_features(view, time, expected, best, found);
    if (!uncertain_) return best;
  }
  best = fit_near(view, expected, reference_, 1, found);
  if (best.certain()) return best;
  best = fit_near(view, expected, reference_, 2, found);
  if (best.supported()) return best;
  // Without the support of the last frame the view itself must convince.
  RelativePose at_last_pose{};
  CameraFit fit = fit_near(view, map_pose(relative_poses_.back()), reference_, 2, at_last_pose);
  if (fit.certain()) {
    found = at_last_pose;
    return fit;
  }
  found = {reference_, map_[reference_].inverse() * expected};
  return best;
}

void CameraTracker::follow(const BackgroundFrame& reduced, const LayerView& view, CameraTrackingResult& result) {
  const SE3 expected = extrapolated(reduced.time, config_.motion.velocity_weight *
                                                      std::pow(config_.motion.velocity_decay, gap_.frames()));
  const SE3 last = map_pose(relative_poses_.back());
  RelativePose relative{};
  const CameraFit fit = find_pose(view, reduced.time, expected, relative);
  const SE3 found = map_pose(relative);
  result.quality = fit.quality;
  result.degenerate_directions = fit.alignment.degenerate_directions;
  const bool anchored = fit.supported() && fit.alignment.degenerate_directions == 0;
  if (anchored && gap_.is_open()) {
    const auto count = static_cast<std::size_t>(gap_.frames());
    const RelativePose& before = relative_poses_.back();
    gaps_.push_back({relative_poses_.size() - count,
                     count,
                     {before.keyframe, map_[before.keyframe].inverse() * extrapolated(reduced.time, 1)}});
  }
  const double step = reduced.time - last_time_;
  if (fit.supported() && step > 0) {
    velocity_ = anchored && gap_.is_open() ? Twist::Zero() : Twist(log_se3(last.inverse() * found) / step);
  }
  const motion::Health health = gap_.add(anchored ? motion::Health::kTracked : motion::Health::kHeld);
  if (anchored) {
    anchor_ = relative;
    anchor_time_ = reduced.time;
  }
  reference_ = relative.keyframe;
  if (!fit.complete()) result.health = fit.supported() ? motion::Health::kHeld : health;
  relative_poses_.push_back(relative);
  if (fit.complete() && !moves()) test_stationarity(view, found);
  if (!moves()) {
    if (fit.complete()) uncertain_ = false;
    return;
  }
  if (fit.complete()) {
    add_lag_evidence(view);
    grow_map(reduced, view, found);
  }
  result.camera_to_world = renormalized(map_to_live_ * map_pose(relative_poses_.back()));
}

void CameraTracker::test_stationarity(const LayerView& view, const SE3& camera_to_map) {
  const StationarityVotes votes = compare_with_stationary(keyframes_.front().points, view, camera_to_map.inverse());
  frames_with_motion_ = votes.show_motion() ? frames_with_motion_ + 1 : 0;
  if (frames_with_motion_ >= config_.frames_to_move) moving_from_ = results_.size();
}

void CameraTracker::grow_map(const BackgroundFrame& reduced, const LayerView& view, const SE3& camera_to_map) {
  const double change = view_change(relative_poses_.back().camera_to_keyframe, keyframes_[reference_].distance);
  // What was found again without features hangs on the map loosely, by a key frame of its own.
  if ((change < config_.keyframe_change && !uncertain_) || keyframes_.size() >= config_.max_keyframes) return;
  const std::size_t previous = reference_;
  add_keyframe(reduced, view, camera_to_map);
  add_edge({previous, reference_, relative_poses_.back().camera_to_keyframe,
            uncertain_ ? config_.uncertain_edge_weight : 1.0});
  uncertain_ = false;
  relative_poses_.back() = {reference_, SE3::Identity()};
  const bool near = close_near_loops(previous, view);
  const bool far = close_far_loops(view);
  if (near || far) optimise_graph();
}

void CameraTracker::add_keyframe(const BackgroundFrame& reduced, const LayerView& view, const SE3& camera_to_map) {
  reference_ = keyframes_.size();
  keyframes_.push_back(make_keyframe(reduced, view));
  keyframes_.back().features = features_of(view, camera_to_map);
  keyframe_frames_.push_back(results_.size());
  map_.push_back(camera_to_map);
  neighbours_.emplace_back();
}

void CameraTracker::add_lag_evidence(const LayerView& view) {
  constexpr std::size_t kEnough = 4096; // 0.5 kB each
  if (lag_evidence_.size() == kEnough) return;
  const RelativePose& last = relative_poses_.back();
  const SE3 keyframe_to_camera = last.camera_to_keyframe.inverse();
  lag_evidence_.push_back({results_.size(), keyframe_frames_[last.keyframe], keyframe_to_camera,
                           depth_against_texture(keyframes_[last.keyframe].points, view, keyframe_to_camera)});
}

void CameraTracker::add_edge(const PoseEdge& edge) {
  edges_.push_back(edge);
  neighbours_[edge.from].push_back(edge.to);
  neighbours_[edge.to].push_back(edge.from);
}

// Compares the newest key frame with others that may see the same, first with those that nothing ties to it.
bool CameraTracker::close_near_loops(std::size_t previous, const LayerView& view) {
  const std::size_t newest = reference_;
  std::vector<std::size_t> candidates;
  std::vector<std::size_t> tied;
  for (const std::size_t k : nearest_keyframes(map_[newest], keyframes_.size())) {
    const SE3 motion = map_[k].inverse() * map_[newest];
    if (k == newest || k == previous || view_change(motion, keyframes_[k].distance) > config_.loop_change) continue;
    const std::vector<std::size_t>& known = neighbours_[previous];
    (std::find(known.begin(), known.end(), k) == known.end() ? candidates : tied).push_back(k);
  }
  candidates.insert(candidates.end(), tied.begin(), tied.end());
  candidates.resize(std::min(candidates.size(), config_.max_loops));
  bool closed = false;
  for (const std::size_t k : candidates) {
    const auto measured = relative_pose(keyframes_[k], keyframes_[newest], view, map_[k].inverse() * map_[newest]);
    if (!measured) continue;
    add_edge({k, newest, *measured});
    ++loops_;
    closed = true;
  }
  return closed;
}

bool CameraTracker::close_far_loops(const LayerView& view) {
  const std::vector<PoseEdge> loops = far_loops_.find_loops(keyframes_, view, map_, edges_);
  for (const PoseEdge& loop : loops) add_edge(loop);
  loops_ += loops.size();
  return !loops.empty();
}

// The live path goes on where it is.
void CameraTracker::optimise_graph() {
  const std::size_t newest = reference_;
  const SE3 live = map_to_live_ * map_[newest];
  optimise_poses(edges_, keyframes_.front().distance, map_);
  map_to_live_ = renormalized(live * map_[newest].inverse());
}

std::vector<SE3> CameraTracker::path() const {
  std::vector<SE3> poses(relative_poses_.size(), SE3::Identity());
  if (!moves()) return poses;
  for (std::size_t i = 0; i < relative_poses_.size(); ++i) poses[i] = renormalized(map_pose(relative_poses_[i]));
  // What the frames of a gap have drifted is shared among them.
  for (const Gap& gap : gaps_) {
    const SE3 drift = poses[gap.first + gap.count] * map_pose(gap.expected).inverse();
    for (std::size_t i = 0; i < gap.count; ++i) {
      const double share = static_cast<double>(i + 1) / static_cast<double>(gap.count + 1);
      SE3& pose = poses[gap.first + i];
      pose = renormalized(interpolate(SE3::Identity(), drift, share) * pose);
    }
  }
  return poses;
}

} // namespace kinora::tracking
