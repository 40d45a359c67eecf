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
TsdfConfig choose_volume(const LayerView& view, double requested) {
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
std::vector<Eigen::Matrix3d> rotations_about(Axes axes, double angle) {
  std::vector<Eigen::Matrix3d> result;
  for (const auto& [x, y, z] : axes) {
    const Eigen::Vector3d axis = Eigen::Vector3d(x, y, z).normalized();
    for (const double rotated : {-angle, angle}) result.emplace_back(Eigen::AngleAxisd(rotated, axis));
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

struct RigidTracker::PreviousFrame {
  LayerView view;
  SE3 model_to_camera;
  SE3 model_to_world;
  PoseQuality quality;
  std::vector<ContourPoint> contour;       ///< in the model, of this view or one before that was like it
  SE3 contour_to_camera = SE3::Identity(); ///< model to camera when it was seen
  std::size_t contour_pixels = 1;          ///< of the label, then
  int contour_age = 0;                     ///< tracked frames
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
  LayerView view = view_label(frame, label_);
  mask_shading(view);
  if (config_.keeps_history) history_.add(frame, view);
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
    is_moved_by_contact_ = false;
    result.pose.health = gap_.add(result.pose.health);
    result.pose.canonical_to_world = canonical_to_world();
  }
  poses_.push_back(result.pose);
  return result;
}

// Light stays where it is while a thing turns. What has shown a print is taken at its whole texture: blurred by motion,
// or from afar, a print is hardly told from light.
void RigidTracker::mask_shading(LayerView& view) {
  if (has_texture_detail_ || view.empty()) return;
  LabelImage detail = detail_of(view.texture, view.mask);
  const auto inner = std::count(view.mask.values().begin(), view.mask.values().end(), MaskArea::kInterior);
  const auto detailed = std::count(detail.values().begin(), detail.values().end(), 1);
  has_texture_detail_ = static_cast<double>(detailed) > config_.min_detail_share * static_cast<double>(inner);
  if (!has_texture_detail_) view.detail = std::move(detail);
}

SE3 RigidTracker::canonical_to_world() const { return model_to_world_ * Eigen::Translation3d(-volume_->origin()); }

bool RigidTracker::is_in_free_space(const ingest::Frame& frame, const SE3& model_to_world) const {
  const SE3 to_camera = frame.camera.camera_to_world.inverse() * model_to_world;
  const Intrinsics& camera = frame.camera.intrinsics;
  std::size_t facing = 0;
  std::size_t violations = 0;
  for (const SurfacePoint& point : surface_) {
    const Eigen::Vector3d position = to_camera * point.position.cast<double>();
    if (position.z() <= 0 || position.dot(to_camera.linear() * point.normal.cast<double>()) >= 0) continue;
    const Eigen::Vector2d pixel = camera.project(position);
    const auto u = static_cast<int>(std::floor(pixel.x() + 0.5));
    const auto v = static_cast<int>(std::floor(pixel.y() + 0.5));
    if (!frame.depth.contains(u, v)) continue;
    ++facing;
    violations += violates_free_space(position.z(), frame.depth.at(u, v), kPoseMargin) ? 1 : 0;
  }
  return static_cast<double>(violations) > config_.let_go_share * static_cast<double>(facing);
}

void RigidTracker::move_with_contact(const ingest::Frame& frame, MissedObject missed, const SE3& motion) {
  if (is_released_) return;
  const SE3 there = renormalized(motion * previous_->model_to_world);
  is_released_ = is_in_free_space(frame, there);
  if (is_released_) return;
  model_to_world_ = there;
  previous_->earlier_model_to_world.reset(); // its motion is what holds it
  is_moved_by_contact_ = true;
  motion::Motion::Pose& pose = poses_.back();
  if (is_visible(missed.view)) {
    const SE3 start = frame.camera.camera_to_world.inverse() * model_to_world_;
    Candidate found = align_from(missed.view, start, start, {});
    for (const SE3& rotated : start_poses(missed.view, frame.camera.camera_to_world, StartSet::kInContact)) {
      Candidate other = align_from(missed.view, rotated, rotated, {});
      if (other.score > found.score + config_.search.min_share_gain) found = std::move(other);
    }
    if (is_relocalised(found.quality)) {
      RigidTrackingResult result;
      accept(frame, std::move(missed.view), found, result);
      pose.health = gap_.add(result.pose.health);
    }
  } else {
    pose.health = motion::Health::kHeld;
  }
  pose.canonical_to_world = canonical_to_world();
}

void RigidTracker::begin(const ingest::Frame& frame, LayerView view, RigidTrackingResult& result) {
  const Eigen::Vector3d centre = frame.camera.camera_to_world * view.centroid;
  volume_ = std::make_unique<TsdfVolume>(choose_volume(view, config_.voxel_size), centre);
  model_to_world_ = SE3(Eigen::Translation3d(centre));
  previous_ = std::make_unique<PreviousFrame>();
  fuse(frame, view);
  previous_->view = std::move(view);
  previous_->quality.explained_share = 1;
  previous_->model_to_world = model_to_world_;
  previous_->model_to_camera = frame.camera.camera_to_world.inverse() * model_to_world_;
  previous_->time = frame.time;
  update_contour();
  keyframes_.emplace_back(previous_->model_to_camera.linear());
  result.visible = true;
  result.pose.health = motion::Health::kTracked;
}

// Constant velocity, of the object's centre and of its rotation about it.
SE3 RigidTracker::predicted(double time) const {
  if (gap_.frames() >= config_.max_predicted_steps || !previous_->earlier_model_to_world) return model_to_world_;
  const double steps = config_.velocity_weight * steps_ahead(previous_->earlier_time, previous_->time, time);
  return extrapolated(*previous_->earlier_model_to_world, model_to_world_, Eigen::Vector3d::Zero(), steps);
}

std::vector<ModelPoint> RigidTracker::visible_points(const LayerView& view, const SE3& model_to_camera) const {
  std::vector<ModelPoint> points = select_points(surface_, view, model_to_camera, config_.max_points);
  // The fused texture is as sharp as the image; at coarse levels the last image stands for it.
  for (ModelPoint& point : points) {
    for (std::size_t level = 1; level < point.texture.size(); ++level) {
      point.texture[level] = std::numeric_limits<float>::quiet_NaN();
    }
    if (gap_.is_open()) continue;
    add_coarse_texture(previous_->view, previous_->model_to_camera, point);
  }
  return points;
}

// An older rim leads to less drift, while the view shows the same edges.
void RigidTracker::update_contour() {
  const double rotated = rotation_angle(previous_->contour_to_camera.inverse() * previous_->model_to_camera);
  const double more =
      static_cast<double>(previous_->view.depth_pixels) / static_cast<double>(previous_->contour_pixels);
  const bool is_recent = !gap_.is_open() && ++previous_->contour_age < config_.contour.max_age &&
                         rotated < config_.contour.max_rotation && std::abs(more - 1) < config_.contour.max_change;
  if (is_recent && !previous_->contour.empty()) return;
  previous_->contour = contour_of(previous_->view);
  const SE3 to_model = previous_->model_to_camera.inverse();
  for (ContourPoint& point : previous_->contour) point.position = to_model * point.position;
  previous_->contour_to_camera = previous_->model_to_camera;
  previous_->contour_pixels = previous_->view.depth_pixels;
  previous_->contour_age = 0;
}

RigidTracker::Candidate RigidTracker::align_from(const LayerView& view, const SE3& start, const SE3& prior,
                                                 const ContourSource& contours) const {
  const std::vector<ModelPoint> points = visible_points(view, start);
  Candidate candidate;
  candidate.alignment = align(points, view, start, prior, contours, config_.alignment);
  const SE3& pose = candidate.alignment.model_to_camera;
  candidate.seen = select_points(surface_, view, pose, config_.max_points);
  candidate.quality = evaluate_pose(candidate.seen, view, pose);
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
  if (quality.free_space_share() > previous_->quality.free_space_share() + config_.search.silhouette_change)
    return true;
  return quality.texture_correlation <= config_.search.certain_correlation &&
         quality.explained_share < previous_->quality.explained_share - config_.search.silhouette_change;
}

// Without the support of the last frame the view itself must be convincing.
bool RigidTracker::is_relocalised(const PoseQuality& quality) const {
  return is_healthy(quality) && quality.inlier_share() >= 0.75 && quality.explained_share >= 0.5 &&
         quality.free_space_share() <= previous_->quality.free_space_share() + config_.search.silhouette_change &&
         (!quality.has_texture() || quality.texture_correlation >= 0.5);
}

// Other places to look, as poses of the model in the camera: where it was last, and moved so that the visible points'
// mean meets the measured one, turned as it was last, as each key frame saw it, or farther than a frame's motion goes;
// turned where it is, as what holds it may have turned it unseen.
std::vector<SE3> RigidTracker::start_poses(const LayerView& view, const SE3& camera_to_world,
                                           StartSet start_set) const {
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
  switch (start_set) {
  case StartSet::kNearPrevious:
    result.push_back(last);
    add_centred(last.linear());
    break;
  case StartSet::kKeyframes:
    for (const Eigen::Matrix3d& rotation : keyframes_) add_centred(rotation);
    break;
  case StartSet::kRotated:
    for (const Eigen::Matrix3d& rotation : rotations_about(kAxes, config_.search.rotation))
      add_centred(rotation * last.linear());
    break;
  case StartSet::kRotatedDiagonally:
    for (const Eigen::Matrix3d& rotation : rotations_about(kDiagonals, config_.search.rotation))
      add_centred(rotation * last.linear());
    break;
  case StartSet::kInContact:
    for (const Eigen::Matrix3d& rotation : rotations_about(kAxes, config_.search.contact_rotation)) {
      result.push_back(last);
      result.back().linear() = rotation * last.linear();
    }
    break;
  }
  return result;
}

// Near to where it is expected, or elsewhere; nothing if no place is to be believed.
std::optional<RigidTracker::Candidate> RigidTracker::find(const ingest::Frame& frame, const LayerView& view,
                                                          RigidTrackingResult& result) {
  std::optional<ContourPair> pair;
  const ContourSource contours = [&]() -> const ContourPair* {
    if (gap_.is_open()) return nullptr;
    if (!pair) pair = ContourPair{previous_->contour, ContourMap(view)};
    return &*pair;
  };
  const SE3 world_to_camera = frame.camera.camera_to_world.inverse();
  const SE3 prior = world_to_camera * predicted(frame.time);
  Candidate best = align_from(view, prior, prior, contours);
  bool elsewhere = false;
  const auto try_start_poses = [&](StartSet start_set) {
    for (const SE3& start : start_poses(view, frame.camera.camera_to_world, start_set)) {
      Candidate other = align_from(view, start, start, {});
      if (other.score < best.score + config_.search.min_share_gain) continue;
      const bool has_rotated_in_contact = is_moved_by_contact_ && start_set != StartSet::kNearPrevious;
      if (has_rotated_in_contact && other.quality.explained_share < config_.search.explained_share) continue;
      best = std::move(other);
      elsewhere = true;
    }
  };
  const auto believed = [&] {
    return !gap_.is_open() && !elsewhere ? is_healthy(best.quality) : is_relocalised(best.quality);
  };
  if (!believed() || is_doubtful(best.quality)) try_start_poses(StartSet::kNearPrevious);
  if (gap_.is_open()) try_start_poses(StartSet::kKeyframes);
  if (!believed() || is_doubtful(best.quality)) try_start_poses(StartSet::kRotated);
  if (!believed()) try_start_poses(StartSet::kRotatedDiagonally);
  result.quality = best.quality;
  const bool shows_its_texture =
      best.quality.has_texture() && best.quality.texture_correlation >= config_.search.doubtful_correlation;
  if (believed() || shows_its_texture) {
    non_rigidity_test_.add(poses_.size(), rigidity_violation(best.seen, view, best.alignment.model_to_camera));
  }
  return believed() ? std::optional(std::move(best)) : std::nullopt;
}

void RigidTracker::accept(const ingest::Frame& frame, LayerView view, const Candidate& best,
                          RigidTrackingResult& result) {
  const Eigen::Matrix3d camera_rotation = frame.camera.camera_to_world.linear();
  result.pose.health = motion::Health::kTracked;
  result.relocalised = gap_.is_open();
  is_released_ = false;
  result.degenerate_directions = best.alignment.degenerate_directions;
  for (int i = 0; i < best.alignment.degenerate_directions; ++i) {
    const Twist direction = best.alignment.directions.col(i);
    Twist in_world;
    in_world << camera_rotation * direction.head<3>(), camera_rotation * direction.tail<3>();
    result.degenerate.push_back(in_world);
  }
  if (!gap_.is_open()) {
    previous_->earlier_model_to_world = previous_->model_to_world;
    previous_->earlier_time = previous_->time;
  } else {
    previous_->earlier_model_to_world.reset();
  }
  model_to_world_ = renormalized(frame.camera.camera_to_world * best.alignment.model_to_camera);
  previous_->view = std::move(view);
  previous_->quality = best.quality;
  previous_->time = frame.time;
  previous_->model_to_world = model_to_world_;
  previous_->model_to_camera = frame.camera.camera_to_world.inverse() * model_to_world_;
  update_contour();
  ++unfused_;
  if (fused_ < config_.fusion.first_frames || unfused_ >= config_.fusion.interval ||
      best.quality.explained_share < config_.fusion.min_coverage) {
    fuse(frame, previous_->view);
  }
  const Eigen::Matrix3d rotation = previous_->model_to_camera.linear();
  const bool is_new = std::all_of(keyframes_.begin(), keyframes_.end(), [&](const Eigen::Matrix3d& known) {
    return Eigen::AngleAxisd(known.transpose() * rotation).angle() > config_.search.keyframe_angle;
  });
  if (is_new && keyframes_.size() < config_.search.max_keyframes) keyframes_.push_back(rotation);
}

void RigidTracker::fuse(const ingest::Frame& frame, const LayerView& view) {
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
