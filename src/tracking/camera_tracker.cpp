#include "tracking/camera_tracker.h"

#include <algorithm>
#include <cmath>

#include "tracking/camera_stillness.h"
#include "tracking/camera_view.h"

namespace kinora::tracking {
namespace {

constexpr double kLongestStep = 0.2;    // seconds that the last velocity is believed to last
constexpr double kVelocityShare = 0.95; // of it that is expected, and
constexpr double kFading = 0.8;         // of that after each frame that shows no motion, or not in all directions
constexpr std::size_t kSearched = 8;    // key frames that a lost camera is looked for at
constexpr std::size_t kPoints = 1200;   // that a frame is aligned to

} // namespace

double CameraTracker::view_change(const SE3& motion, double distance) {
  return rotation_angle(motion) + motion.translation().norm() / distance;
}

CameraTrackingResult CameraTracker::track(const ingest::Frame& frame) {
  const BackgroundFrame reduced = reduce_background(frame);
  const ObjectView view = view_background(reduced);
  CameraTrackingResult result;
  if (config_.frames_to_move == 0 && !moves()) moving_from_ = 0;
  if (!keyframes_.empty()) {
    follow(reduced, view, result);
  } else {
    places_.push_back({0, SE3::Identity()});
    if (view.depth_pixels >= config_.min_pixels) {
      add_keyframe(reduced, view, SE3::Identity());
    } else {
      result.health = Health::kLost;
    }
  }
  last_time_ = reduced.time;
  results_.push_back(result);
  return result;
}

// Where constant velocity, or a share of it, leads from the last place.
SE3 CameraTracker::carried_on(double time, double share) const {
  const double step = std::clamp(time - last_time_, 0.0, kLongestStep);
  return map_pose(places_.back()) * exp_se3(share * step * velocity_);
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

CameraFit CameraTracker::fit_near(const ObjectView& view, const SE3& camera_to_map, std::size_t reference,
                                  int coarsest_level, Place& found) const {
  const std::vector<std::size_t> references = references_for(camera_to_map, reference);
  const SE3& origin = map_[references.front()];
  std::vector<ModelPoint> points;
  for (std::size_t r = 0; r < references.size(); ++r) {
    const SE3 to_origin = origin.inverse() * map_[references[r]];
    const Eigen::Matrix3f rotation = to_origin.linear().cast<float>();
    const Eigen::Vector3f translation = to_origin.translation().cast<float>();
    const std::vector<ModelPoint>& own = keyframes_[references[r]].points;
    const std::size_t share = kPoints / references.size();
    for (std::size_t k = 0; k < std::min(share, own.size()); ++k) {
      ModelPoint point = own[k * own.size() / std::min(share, own.size())];
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

// At the place that is expected, else where it was last, else, if it has been lost, at the key frames around.
CameraFit CameraTracker::search(const ObjectView& view, const SE3& expected, Place& found) const {
  CameraFit best = fit_near(view, expected, reference_, 1, found);
  if (best.certain()) return best;
  best = fit_near(view, expected, reference_, 2, found);
  if (best.supported()) return best;
  const auto try_at = [&](const SE3& camera_to_map, std::size_t reference) {
    Place elsewhere{};
    CameraFit fit = fit_near(view, camera_to_map, reference, 2, elsewhere);
    if (!fit.certain()) return false; // without the support of the last frame the view itself must convince
    best = std::move(fit);
    found = elsewhere;
    return true;
  };
  const SE3 last = map_pose(places_.back());
  if (try_at(last, reference_)) return best;
  if (gap_ > 0) {
    for (const std::size_t k : nearest_keyframes(last, kSearched)) {
      if (try_at(map_[k], k)) return best;
    }
  }
  found = {reference_, map_[reference_].inverse() * expected};
  return best;
}

void CameraTracker::follow(const BackgroundFrame& reduced, const ObjectView& view, CameraTrackingResult& result) {
  const SE3 expected = carried_on(reduced.time, kVelocityShare * std::pow(kFading, gap_));
  const SE3 last = map_pose(places_.back());
  Place place{};
  const CameraFit fit = search(view, expected, place);
  const SE3 found = map_pose(place);
  result.quality = fit.quality;
  result.weak_directions = fit.alignment.weak_directions;
  const bool anchored = fit.supported() && fit.alignment.weak_directions == 0;
  if (anchored) bridge_gap(found * carried_on(reduced.time, 1).inverse());
  const double step = reduced.time - last_time_;
  if (fit.supported() && step > 0) {
    velocity_ = anchored && gap_ > 0 ? Twist::Zero() : Twist(log_se3(last.inverse() * found) / step);
  }
  gap_ = anchored ? 0 : gap_ + 1;
  reference_ = place.keyframe;
  if (!fit.complete()) {
    result.health = fit.supported() || gap_ <= config_.held_frames ? Health::kHeld : Health::kLost;
  }
  places_.push_back(place);
  if (fit.complete() && !moves()) judge_stillness(view, found);
  if (!moves()) return;
  if (fit.complete()) grow_map(reduced, view, found);
  result.camera_to_world = renormalized(map_to_live_ * map_pose(places_.back()));
}

void CameraTracker::judge_stillness(const ObjectView& view, const SE3& camera_to_map) {
  const StillnessVotes votes = compare_with_still(keyframes_.front().points, view, camera_to_map.inverse());
  showing_motion_ = votes.show_motion() ? showing_motion_ + 1 : 0;
  if (showing_motion_ >= config_.frames_to_move) moving_from_ = results_.size();
}

// What the frames have drifted in which some directions followed the motion before them is shared among them.
void CameraTracker::bridge_gap(const SE3& drift) {
  for (int i = 0; i < gap_; ++i) {
    Place& place = places_[places_.size() - static_cast<std::size_t>(gap_ - i)];
    const double share = static_cast<double>(i + 1) / static_cast<double>(gap_ + 1);
    place.camera_to_keyframe =
        map_[place.keyframe].inverse() * interpolate(SE3::Identity(), drift, share) * map_pose(place);
  }
}

void CameraTracker::grow_map(const BackgroundFrame& reduced, const ObjectView& view, const SE3& camera_to_map) {
  const double change = view_change(places_.back().camera_to_keyframe, keyframes_[reference_].distance);
  if (change < config_.keyframe_change || keyframes_.size() >= config_.max_keyframes) return;
  const std::size_t previous = reference_;
  add_keyframe(reduced, view, camera_to_map);
  connect(previous, reference_, places_.back().camera_to_keyframe);
  places_.back() = {reference_, SE3::Identity()};
  close_loops(previous);
}

void CameraTracker::add_keyframe(const BackgroundFrame& reduced, const ObjectView& view, const SE3& camera_to_map) {
  reference_ = keyframes_.size();
  keyframes_.push_back(make_keyframe(reduced, view));
  map_.push_back(camera_to_map);
  neighbours_.emplace_back();
}

void CameraTracker::connect(std::size_t from, std::size_t to, const SE3& to_in_from) {
  edges_.push_back({from, to, to_in_from});
  neighbours_[from].push_back(to);
  neighbours_[to].push_back(from);
}

// Compares the newest key frame with others that may see the same, first with those that nothing ties to it.
void CameraTracker::close_loops(std::size_t previous) {
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
    const auto measured = relate(keyframes_[k], keyframes_[newest], map_[k].inverse() * map_[newest]);
    if (!measured) continue;
    connect(k, newest, *measured);
    ++loops_;
    closed = true;
  }
  if (!closed) return;
  const SE3 live = map_to_live_ * map_[newest];
  optimise_poses(edges_, keyframes_.front().distance, map_);
  map_to_live_ = renormalized(live * map_[newest].inverse());
}

std::vector<SE3> CameraTracker::path() const {
  std::vector<SE3> poses(places_.size(), SE3::Identity());
  if (!moves()) return poses;
  for (std::size_t i = 0; i < places_.size(); ++i) poses[i] = renormalized(map_pose(places_[i]));
  return poses;
}

} // namespace kinora::tracking
