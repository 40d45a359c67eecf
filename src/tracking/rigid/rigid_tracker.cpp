#include "tracking/rigid/rigid_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/sensor_noise.h"
#include "tracking/rigid/constant_velocity.h"
#include "tracking/rigid/point_selection.h"

namespace kinora::tracking {
namespace {

constexpr double kMinVoxel = 0.001;
constexpr double kMaxVoxel = 0.03;

// About a pixel's footprint and no finer than the sensor's noise, which would only be modelled as roughness; no more
// than a hundred voxels across the object.
TsdfConfig choose_volume(const ObjectView& view, double requested) {
  double squared = 0;
  for (int v = 0; v < view.mask.height(); ++v) {
    for (int u = 0; u < view.mask.width(); ++u) {
      if (view.planes.weights.at(u, v) > 0) squared += (view.point(u, v) - view.centroid).squaredNorm();
    }
  }
  const double size = 3.0 * std::sqrt(squared / static_cast<double>(view.depth_pixels));
  const double footprint = view.centroid.z() / view.intrinsics.fx;
  const double sigma = kSensorNoise.sigma(view.centroid.z());
  const double wanted = std::max({1.1 * footprint, 1.1 * sigma, size / 100});
  TsdfConfig config;
  config.voxel_size = requested > 0 ? requested : std::clamp(wanted, kMinVoxel, kMaxVoxel);
  config.truncation = std::clamp(4 * sigma, 4 * config.voxel_size, 7 * config.voxel_size);
  return config;
}

using Axes = std::span<const std::array<int, 3>>;
constexpr std::array<std::array<int, 3>, 3> kAxes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
constexpr std::array<std::array<int, 3>, 10> kDiagonals{{{1, 1, 0},
                                                         {1, -1, 0},
                                                         {1, 0, 1},
                                                         {1, 0, -1},
                                                         {0, 1, 1},
                                                         {0, 1, -1},
                                                         {1, 1, 1},
                                                         {1, 1, -1},
                                                         {1, -1, 1},
                                                         {-1, 1, 1}}};

// About each axis, both ways.
std::vector<Eigen::Matrix3d> turns(Axes axes, double angle) {
  std::vector<Eigen::Matrix3d> result;
  for (const auto& [x, y, z] : axes) {
    const Eigen::Vector3d axis = Eigen::Vector3d(x, y, z).normalized();
    for (const double turned : {-angle, angle}) result.emplace_back(Eigen::AngleAxisd(turned, axis));
  }
  return result;
}

} // namespace

struct RigidTracker::Candidate {
  Alignment alignment;
  PoseQuality quality;
  double score = -1;
  std::vector<ModelPoint> seen; ///< there
};

struct RigidTracker::Past {
  ObjectView view;
  SE3 model_to_camera;
  SE3 model_to_world;
  PoseQuality quality;
  std::vector<RimPoint> rim;           ///< in the model, of this view or one before that was like it
  SE3 rim_to_camera = SE3::Identity(); ///< model to camera when it was seen
  std::size_t rim_pixels = 1;          ///< of the label, then
  int rim_age = 0;                     ///< tracked frames
  double time = 0;
  /// The tracked pose before, if it was the frame before.
  std::optional<SE3> earlier_model_to_world;
  double earlier_time = 0;
};

RigidTracker::RigidTracker(int label, const RigidTrackerConfig& config)
    : label_(label), config_(config), gap_(config.held_frames) {}
RigidTracker::~RigidTracker() = default;
RigidTracker::RigidTracker(RigidTracker&&) noexcept = default;
RigidTracker& RigidTracker::operator=(RigidTracker&&) noexcept = default;

RigidTrackingResult RigidTracker::track(const ingest::Frame& frame) {
  ObjectView view = view_object(frame, label_);
  leave_out_shading(view);
  if (config_.remembers) memory_.add(frame, view);
  RigidTrackingResult result;
  result.pixels = view.depth_pixels;
  if (volume_ == nullptr) {
    result.pose.health = motion::Health::kLost;
    if (view.depth_pixels >= config_.first_pixels) begin(frame, std::move(view), result);
  } else {
    result.visible = is_visible(view);
    if (const auto found = result.visible ? find(frame, view, result) : std::nullopt) {
      accept(frame, std::move(view), *found, result);
    } else {
      result.pose.health = result.visible ? motion::Health::kLost : motion::Health::kHeld;
      result.missed = MissedObject{std::move(view)};
    }
    is_carried_ = false;
    result.pose.health = gap_.add(result.pose.health);
    result.pose.canonical_to_world = canonical_to_world();
  }
  poses_.push_back(result.pose);
  return result;
}

// Light stays where it is while a thing turns. What has shown a print is taken at its whole texture: blurred by motion,
// or from afar, a print is hardly told from light.
void RigidTracker::leave_out_shading(ObjectView& view) {
  if (wears_print_ || view.empty()) return;
  LabelImage detail = detail_of(view.texture, view.mask);
  const auto inner = std::count(view.mask.values().begin(), view.mask.values().end(), MaskArea::kInterior);
  const auto printed = std::count(detail.values().begin(), detail.values().end(), 1);
  wears_print_ = static_cast<double>(printed) > config_.print_share * static_cast<double>(inner);
  if (!wears_print_) view.detail = std::move(detail);
}

SE3 RigidTracker::canonical_to_world() const { return model_to_world_ * Eigen::Translation3d(-volume_->origin()); }

bool RigidTracker::is_in_free_space(const ingest::Frame& frame, const SE3& model_to_world) const {
  const SE3 to_camera = frame.camera.camera_to_world.inverse() * model_to_world;
  const Intrinsics& camera = frame.camera.intrinsics;
  std::size_t facing = 0;
  std::size_t violations = 0;
  for (const SurfacePoint& point : surface_) {
    const Eigen::Vector3d place = to_camera * point.position.cast<double>();
    if (place.z() <= 0 || place.dot(to_camera.linear() * point.normal.cast<double>()) >= 0) continue;
    const Eigen::Vector2d pixel = camera.project(place);
    const auto u = static_cast<int>(std::floor(pixel.x() + 0.5));
    const auto v = static_cast<int>(std::floor(pixel.y() + 0.5));
    if (!frame.depth.contains(u, v)) continue;
    ++facing;
    violations += violates_free_space(place.z(), frame.depth.at(u, v), kPoseMargin) ? 1 : 0;
  }
  return static_cast<double>(violations) > config_.let_go_share * static_cast<double>(facing);
}

void RigidTracker::carry(const ingest::Frame& frame, MissedObject missed, const SE3& motion) {
  if (is_let_go_) return;
  const SE3 there = renormalized(motion * past_->model_to_world);
  is_let_go_ = is_in_free_space(frame, there);
  if (is_let_go_) return;
  model_to_world_ = there;
  past_->earlier_model_to_world.reset(); // its motion is what holds it
  is_carried_ = true;
  motion::Motion::Pose& pose = poses_.back();
  if (is_visible(missed.view)) {
    const SE3 start = frame.camera.camera_to_world.inverse() * model_to_world_;
    Candidate found = attempt(missed.view, start, start, {});
    for (const SE3& turned : starts(missed.view, frame.camera.camera_to_world, Where::kInHand)) {
      Candidate other = attempt(missed.view, turned, turned, {});
      if (other.score > found.score + config_.search.clearly_better) found = std::move(other);
    }
    if (is_found_again(found.quality)) {
      RigidTrackingResult result;
      accept(frame, std::move(missed.view), found, result);
      pose.health = gap_.add(result.pose.health);
    }
  } else {
    pose.health = motion::Health::kHeld;
  }
  pose.canonical_to_world = canonical_to_world();
}

void RigidTracker::begin(const ingest::Frame& frame, ObjectView view, RigidTrackingResult& result) {
  const Eigen::Vector3d centre = frame.camera.camera_to_world * view.centroid;
  volume_ = std::make_unique<TsdfVolume>(choose_volume(view, config_.voxel_size), centre);
  model_to_world_ = SE3(Eigen::Translation3d(centre));
  past_ = std::make_unique<Past>();
  fuse(frame, view);
  past_->view = std::move(view);
  past_->quality.explained_share = 1;
  past_->model_to_world = model_to_world_;
  past_->model_to_camera = frame.camera.camera_to_world.inverse() * model_to_world_;
  past_->time = frame.time;
  renew_rim();
  keyframes_.emplace_back(past_->model_to_camera.linear());
  result.visible = true;
  result.pose.health = motion::Health::kTracked;
}

// Constant velocity, of the object's centre and of its rotation about it.
SE3 RigidTracker::predicted(double time) const {
  if (gap_.frames() >= config_.max_predicted_steps || !past_->earlier_model_to_world) return model_to_world_;
  const double steps = config_.velocity_share * steps_ahead(past_->earlier_time, past_->time, time);
  return extrapolated(*past_->earlier_model_to_world, model_to_world_, Eigen::Vector3d::Zero(), steps);
}

std::vector<ModelPoint> RigidTracker::visible_points(const ObjectView& view, const SE3& model_to_camera) const {
  std::vector<ModelPoint> points = select_points(surface_, view, model_to_camera, config_.max_points);
  // The fused texture is as sharp as the image; at coarse levels the last image stands for it.
  for (ModelPoint& point : points) {
    for (std::size_t level = 1; level < point.texture.size(); ++level) {
      point.texture[level] = std::numeric_limits<float>::quiet_NaN();
    }
    if (gap_.is_open()) continue;
    add_coarse_texture(past_->view, past_->model_to_camera, point);
  }
  return points;
}

// An older rim leads to less drift, while the view shows the same edges.
void RigidTracker::renew_rim() {
  const double turned = rotation_angle(past_->rim_to_camera.inverse() * past_->model_to_camera);
  const double more = static_cast<double>(past_->view.depth_pixels) / static_cast<double>(past_->rim_pixels);
  const bool serves = !gap_.is_open() && ++past_->rim_age < config_.contour.max_age &&
                      turned < config_.contour.max_rotation && std::abs(more - 1) < config_.contour.max_change;
  if (serves && !past_->rim.empty()) return;
  past_->rim = rim_of(past_->view);
  const SE3 to_model = past_->model_to_camera.inverse();
  for (RimPoint& point : past_->rim) point.place = to_model * point.place;
  past_->rim_to_camera = past_->model_to_camera;
  past_->rim_pixels = past_->view.depth_pixels;
  past_->rim_age = 0;
}

RigidTracker::Candidate RigidTracker::attempt(const ObjectView& view, const SE3& start, const SE3& prior,
                                              const RimSource& rims) const {
  const std::vector<ModelPoint> points = visible_points(view, start);
  Candidate candidate;
  candidate.alignment = align(points, view, start, prior, rims, config_.alignment);
  const SE3& pose = candidate.alignment.model_to_camera;
  candidate.seen = select_points(surface_, view, pose, config_.max_points);
  candidate.quality = judge_pose(candidate.seen, view, pose);
  const PoseQuality& quality = candidate.quality;
  candidate.score =
      quality.inlier_share() + quality.explained_share + quality.texture_correlation - quality.free_space_share();
  return candidate;
}

bool RigidTracker::is_healthy(const PoseQuality& quality) const {
  return quality.inliers >= config_.min_pixels / 2 && quality.inlier_share() >= config_.min_inlier_share &&
         quality.free_space_share() <= config_.max_free_space_share &&
         (!quality.has_texture() || quality.texture_correlation >= config_.min_correlation);
}

// A shape may have slid along itself where texture does not tell, or to where little of it is left to have any, and its
// silhouette says so.
bool RigidTracker::is_doubtful(const PoseQuality& quality) const {
  if (quality.has_texture() && quality.texture_correlation < config_.search.doubtful_correlation) return true;
  if (quality.free_space_share() > past_->quality.free_space_share() + config_.search.silhouette_change) return true;
  return quality.texture_correlation <= config_.search.certain_correlation &&
         quality.explained_share < past_->quality.explained_share - config_.search.silhouette_change;
}

// Without the support of the last frame the view itself must be convincing.
bool RigidTracker::is_found_again(const PoseQuality& quality) const {
  return is_healthy(quality) && quality.inlier_share() >= 0.75 && quality.explained_share >= 0.5 &&
         quality.free_space_share() <= past_->quality.free_space_share() + config_.search.silhouette_change &&
         (!quality.has_texture() || quality.texture_correlation >= 0.5);
}

// Other places to look, as poses of the model in the camera: where it was last, and moved so that the visible points'
// mean meets the measured one, turned as it was last, as each key frame saw it, or farther than a frame's motion goes;
// turned where it is, as what holds it may have turned it unseen.
std::vector<SE3> RigidTracker::starts(const ObjectView& view, const SE3& camera_to_world, Where where) const {
  std::vector<SE3> result;
  const SE3 last = camera_to_world.inverse() * model_to_world_;
  const auto add_centred = [&](const Eigen::Matrix3d& rotation) {
    SE3 pose = SE3::Identity();
    pose.linear() = rotation;
    pose.translation() = view.centroid;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const std::vector<ModelPoint> points = select_points(surface_, view, pose, config_.max_points);
    if (points.empty()) return;
    for (const ModelPoint& point : points) sum += pose * point.position.cast<double>();
    pose.translation() += view.centroid - sum / static_cast<double>(points.size());
    result.push_back(pose);
  };
  switch (where) {
  case Where::kNear:
    result.push_back(last);
    add_centred(last.linear());
    break;
  case Where::kAsBefore:
    for (const Eigen::Matrix3d& rotation : keyframes_) add_centred(rotation);
    break;
  case Where::kTurned:
    for (const Eigen::Matrix3d& turn : turns(kAxes, config_.search.rotation)) add_centred(turn * last.linear());
    break;
  case Where::kTurnedDiagonally:
    for (const Eigen::Matrix3d& turn : turns(kDiagonals, config_.search.rotation)) add_centred(turn * last.linear());
    break;
  case Where::kInHand:
    for (const Eigen::Matrix3d& turn : turns(kAxes, config_.search.rotation_in_hand)) {
      result.push_back(last);
      result.back().linear() = turn * last.linear();
    }
    break;
  }
  return result;
}

// Near to where it is expected, or elsewhere; nothing if no place is to be believed.
std::optional<RigidTracker::Candidate> RigidTracker::find(const ingest::Frame& frame, const ObjectView& view,
                                                          RigidTrackingResult& result) {
  std::optional<RimPair> pair;
  const RimSource rims = [&]() -> const RimPair* {
    if (gap_.is_open()) return nullptr;
    if (!pair) pair = RimPair{past_->rim, RimMap(view)};
    return &*pair;
  };
  const SE3 world_to_camera = frame.camera.camera_to_world.inverse();
  const SE3 prior = world_to_camera * predicted(frame.time);
  Candidate best = attempt(view, prior, prior, rims);
  bool elsewhere = false;
  const auto try_starts = [&](Where where) {
    for (const SE3& start : starts(view, frame.camera.camera_to_world, where)) {
      Candidate other = attempt(view, start, start, {});
      if (other.score < best.score + config_.search.clearly_better) continue;
      const bool has_turned_in_hand = is_carried_ && where != Where::kNear;
      if (has_turned_in_hand && other.quality.explained_share < config_.search.explained_share) continue;
      best = std::move(other);
      elsewhere = true;
    }
  };
  const auto believed = [&] {
    return !gap_.is_open() && !elsewhere ? is_healthy(best.quality) : is_found_again(best.quality);
  };
  if (!believed() || is_doubtful(best.quality)) try_starts(Where::kNear);
  if (gap_.is_open()) try_starts(Where::kAsBefore);
  if (!believed() || is_doubtful(best.quality)) try_starts(Where::kTurned);
  if (!believed()) try_starts(Where::kTurnedDiagonally);
  result.quality = best.quality;
  const bool shows_its_texture =
      best.quality.has_texture() && best.quality.texture_correlation >= config_.search.doubtful_correlation;
  if (believed() || shows_its_texture) {
    bending_.add(poses_.size(), contradiction_of_rigid(best.seen, view, best.alignment.model_to_camera));
  }
  return believed() ? std::optional(std::move(best)) : std::nullopt;
}

void RigidTracker::accept(const ingest::Frame& frame, ObjectView view, const Candidate& best,
                          RigidTrackingResult& result) {
  const Eigen::Matrix3d camera_rotation = frame.camera.camera_to_world.linear();
  result.pose.health = motion::Health::kTracked;
  result.relocalised = gap_.is_open();
  is_let_go_ = false;
  result.weak_directions = best.alignment.weak_directions;
  for (int i = 0; i < best.alignment.weak_directions; ++i) {
    const Twist direction = best.alignment.directions.col(i);
    Twist in_world;
    in_world << camera_rotation * direction.head<3>(), camera_rotation * direction.tail<3>();
    result.weak.push_back(in_world);
  }
  if (!gap_.is_open()) {
    past_->earlier_model_to_world = past_->model_to_world;
    past_->earlier_time = past_->time;
  } else {
    past_->earlier_model_to_world.reset();
  }
  model_to_world_ = renormalized(frame.camera.camera_to_world * best.alignment.model_to_camera);
  past_->view = std::move(view);
  past_->quality = best.quality;
  past_->time = frame.time;
  past_->model_to_world = model_to_world_;
  past_->model_to_camera = frame.camera.camera_to_world.inverse() * model_to_world_;
  renew_rim();
  ++unfused_;
  if (fused_ < config_.fusion.first_frames || unfused_ >= config_.fusion.interval ||
      best.quality.explained_share < config_.fusion.known_share) {
    fuse(frame, past_->view);
  }
  const Eigen::Matrix3d rotation = past_->model_to_camera.linear();
  const bool is_new = std::all_of(keyframes_.begin(), keyframes_.end(), [&](const Eigen::Matrix3d& known) {
    return Eigen::AngleAxisd(known.transpose() * rotation).angle() > config_.search.keyframe_angle;
  });
  if (is_new && keyframes_.size() < config_.search.max_keyframes) keyframes_.push_back(rotation);
}

void RigidTracker::fuse(const ingest::Frame& frame, const ObjectView& view) {
  DepthPlanes planes = view.planes;
  const SE3 model_to_camera = frame.camera.camera_to_world.inverse() * model_to_world_;
  remove_occluders(surface_, model_to_camera, view, planes);
  const SE3 canonical_to_camera = model_to_camera * Eigen::Translation3d(-volume_->origin());
  volume_->integrate(planes, view.texture, view.intrinsics, canonical_to_camera.inverse());
  surface_ = volume_->surface_points();
  ++fused_;
  unfused_ = 0;
}

} // namespace kinora::tracking
