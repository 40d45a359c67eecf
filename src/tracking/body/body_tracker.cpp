#include "tracking/body/body_tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "core/parallel.h"
#include "tracking/body/body_fit.h"
#include "tracking/body/body_match.h"

namespace kinora::tracking {
namespace {

// Deviations of a pose from what is predicted a thirtieth of a second ahead.
constexpr double kUsualInterval = 1.0 / 30;
constexpr std::array<Limb, 2> kArms = {kLeftArm, kRightArm};

bool is_below(int joint, Joint ancestor) {
  while (joint >= 0 && joint != ancestor) joint = joints()[static_cast<std::size_t>(joint)].parent;
  return joint == ancestor;
}

double angle_sigma(int joint, const BodyMotionConfig& config) {
  if (is_below(joint, kLeftShoulder) || is_below(joint, kRightShoulder)) return config.arm_rotation;
  if (is_below(joint, kLeftHip) || is_below(joint, kRightHip)) return config.leg_rotation;
  return config.trunk_rotation;
}

BodyState transformed(const SE3& transform, const BodyState& state) {
  BodyState result = state;
  result.pose.root = transform * state.pose.root;
  return result;
}

} // namespace

BodyTrackingResult BodyTracker::track(const LayerView& view, const SE3& camera_to_world, double time,
                                      std::span<const NearbyObject> objects) {
  const double seconds = std::max(time - time_, 1e-3);
  time_ = time;
  BodyTrackingResult result;
  if (started_ ? view.depth_pixels < config_.min_pixels : view.depth_pixels < config_.first_pixels) {
    velocity_.setZero();
    result.health = started_ ? motion::Health::kHeld : motion::Health::kLost;
    result.limbs.fill(LimbHealth::kHidden);
    if (started_) ++lost_frames_;
  } else {
    if (!started_ || lost_frames_ >= config_.lost_frames) begin(view, camera_to_world);
    follow(gather_evidence(view, config_.max_points, config_.energy), camera_to_world, seconds, objects, result);
    lost_frames_ = result.health == motion::Health::kLost ? lost_frames_ + 1 : 0;
  }
  return result;
}

void BodyTracker::begin(const LayerView& view, const SE3& camera_to_world) {
  const std::vector<BodyPose> earlier = pose_database_.about(view.centroid);
  state_ = transformed(camera_to_world, fit_body(view, known_, config_.energy, earlier).state);
  velocity_.setZero();
  started_ = true;
  lost_frames_ = 0;
  fresh_ = true;
}

BodyState BodyTracker::predicted(double seconds) const {
  BodyState state = state_;
  state.pose = moved(state_.pose, config_.motion.velocity_weight * std::min(seconds, 3 * kUsualInterval) * velocity_);
  return state;
}

PoseStep BodyTracker::pose_precision(double seconds) const {
  PoseStep deviation;
  deviation.head<3>().setConstant(config_.motion.root_translation);
  deviation.segment<3>(3).setConstant(config_.motion.root_rotation);
  for (int j = 0; j < kJoints; ++j) {
    const JointInfo& joint = joints()[static_cast<std::size_t>(j)];
    deviation.segment(6 + joint.first_angle, joint.angle_count).setConstant(angle_sigma(j, config_.motion));
  }
  return (seconds / kUsualInterval * deviation).cwiseAbs2().cwiseInverse();
}

void BodyTracker::follow(BodyEvidence evidence, const SE3& camera_to_world, double seconds,
                         std::span<const NearbyObject> objects, BodyTrackingResult& result) {
  const SE3 world_to_camera = camera_to_world.inverse();
  BodyPrior prior = known_;
  const bool learning = shape_frames_ < config_.shape_frames;
  const BodyState expected = predicted(seconds);
  BodyState state = transformed(world_to_camera, expected);
  prior.state.pose = state.pose;
  result.detected = evidence.joints.size();
  const std::vector<JointObservation> before = std::exchange(observed_, evidence.joints);
  if (!fresh_) {
    evidence.joints =
        consistent_observations(observed_, before, pose_body(state.pose, state.shape), config_.energy.detected);
  }
  prior.pose_precision = pose_precision(seconds);
  for (std::size_t i = 0; i < kArms.size(); ++i) {
    if (const auto position = contacts_.position_of(i, objects)) {
      prior.hands.push_back({kArms[i], world_to_camera * *position});
    }
  }
  const double energy = minimise(evidence, prior, config_.energy, config_.iterations, learning, state);
  // Who jumps as a whole is where the middle of what is measured has gone.
  const Eigen::Vector3d middle = camera_to_world * evidence.view->centroid;
  const Eigen::Vector3d step = expected.pose.root.translation() - state_.pose.root.translation();
  const Eigen::Vector3d jump = world_to_camera.linear() * (middle - std::exchange(middle_, middle) - step);
  if (config_.use_searches && !fresh_ && jump.norm() > config_.search.jump) {
    BodyPrior there = prior;
    there.state.pose.root.translation() += jump;
    BodyState other{there.state.pose, state_.shape};
    if (minimise(evidence, there, config_.energy, config_.iterations, learning, other) < energy) {
      state = other;
      prior = there;
    }
  }
  search_limbs(evidence, prior, state, result);
  result.refitted = fresh_;
  parallel_for(2, 1, [&](const Chunk& which) {
    if (which.begin == 0) result.explained = explained_share(evidence, state);
    if (which.begin == 1) result.free_space_share = free_space_share(evidence, state);
  });
  result.health = result.explained >= config_.min_explained ? motion::Health::kTracked : motion::Health::kLost;
  if (learning && result.health == motion::Health::kTracked) learn_shape(evidence, state);
  if (result.health == motion::Health::kTracked) {
    pose_database_.add(state.pose, forward_kinematics(state.pose, state.shape), evidence.view->centroid);
  }
  move_to(transformed(camera_to_world, state), seconds);
  if (result.health == motion::Health::kTracked) update_contacts(objects, result);
}

void BodyTracker::update_contacts(std::span<const NearbyObject> objects, const BodyTrackingResult& result) {
  const PosedBody body = pose_body(state_.pose, state_.shape);
  std::vector<Eigen::Vector3d> positions;
  std::vector<double> seen;
  for (const Limb arm : kArms) {
    positions.push_back(heel_of_hand(body, arm));
    seen.push_back(result.limbs[arm] == LimbHealth::kSeen ? 1 : 0);
  }
  contacts_.update(objects, positions, seen);
}

// What a fit has left to do, and what a search has found, is no motion.
void BodyTracker::move_to(const BodyState& state, double seconds) {
  velocity_ = step_between(state_.pose, state.pose) / seconds;
  state_ = state;
  if (fresh_) velocity_.setZero();
  fresh_ = false;
  for (const Limb limb : kEveryLimb) {
    if (!jumped_[limb]) continue;
    const LimbChain& chain = chain_of(limb);
    for (const Joint joint : {chain.ball, chain.hinge, chain.end}) {
      velocity_.segment(6 + joints()[joint].first_angle, joints()[joint].angle_count).setZero();
    }
  }
}

// What the frame says of the measures alone, whatever the pose may be, is kept (Schur complement); frames are not
// independent of each other.
void BodyTracker::learn_shape(const BodyEvidence& evidence, const BodyState& in_camera) {
  constexpr double kIndependent = 0.2;
  BodyPrior open;
  open.state = in_camera;
  const BodyEquations equations = evaluate(evidence, in_camera, open, config_.energy);
  const auto& h = equations.hessian;
  const Eigen::MatrixXd pose =
      h.topLeftCorner<kPoseDof, kPoseDof>() + 1e-6 * Eigen::MatrixXd::Identity(kPoseDof, kPoseDof);
  const Eigen::MatrixXd coupling = h.topRightCorner<kPoseDof, kMeasures>();
  known_.shape_precision +=
      kIndependent * (h.bottomRightCorner<kMeasures, kMeasures>() - coupling.transpose() * pose.ldlt().solve(coupling));
  known_.state.shape = in_camera.shape;
  ++shape_frames_;
}

void BodyTracker::search_limbs(const BodyEvidence& evidence, const BodyPrior& prior, BodyState& state,
                               BodyTrackingResult& result) {
  jumped_.fill(false);
  std::array<LimbVisibility, kLimbs> visibilities;
  const auto observe = [&](const Chunk& limbs) {
    const auto limb = static_cast<Limb>(limbs.begin);
    visibilities[limb] = observe_limb(limb, evidence, state, config_.energy);
  };
  parallel_for(visibilities.size(), 1, observe);
  for (const Limb limb : kEveryLimb) {
    const LimbVisibility& visibility = visibilities[limb];
    const bool is_in_contact = std::any_of(prior.hands.begin(), prior.hands.end(),
                                           [&](const HandContact& contact) { return contact.arm == limb; });
    // Where a limb was not seen, it is only guessed to be.
    const bool guessed = limbs_[limb] != LimbHealth::kSeen && health_of(visibility) != LimbHealth::kSeen;
    const bool doubtful =
        visibility.unexplained > (guessed ? config_.search.unexplained_beside_unseen : config_.search.unexplained) ||
        visibility.free_space > config_.search.max_free_space_share * (visibility.seen + visibility.hidden) ||
        (visibility.detected_elsewhere > 0 && !is_in_contact);
    if (search_pause_[limb] > 0) {
      --search_pause_[limb];
    } else if (doubtful && config_.use_searches) {
      jumped_[limb] = search_limb(limb, evidence, prior, config_.energy, config_.search.margin,
                                  guessed ? config_.search.unseen_jump_cost : config_.search.jump_cost, state);
      if (jumped_[limb]) parallel_for(visibilities.size(), 1, observe); // it may hide others, or explain what they did
      if (!jumped_[limb]) search_pause_[limb] = config_.search.pause;
    }
    result.limbs[limb] = health_of(visibility);
  }
  limbs_ = result.limbs;
}

double BodyTracker::explained_share(const BodyEvidence& evidence, const BodyState& in_camera) const {
  const BodyInCamera body(in_camera);
  const double least = config_.energy.cutoff * config_.energy.cutoff;
  double total = 0;
  double explained = 0;
  std::vector<PartMatch> matches(evidence.points.size());
  match_points(body, evidence.points, config_.energy.normal_length, least, matches);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    total += evidence.points[i].weight;
    if (matches[i].part >= 0) explained += evidence.points[i].weight;
  }
  return total > 0 ? explained / total : 0.0;
}

double BodyTracker::free_space_share(const BodyEvidence& evidence, const BodyState& in_camera) const {
  const BodyInCamera body(in_camera);
  double total = 0;
  double violating = 0;
  for (const BodySample& sample : body_samples()) {
    const SampleResidual r = sample_residual(body, sample, *evidence.view, config_.energy);
    if (r.visibility == Visibility::kSeen || r.visibility == Visibility::kFreeSpace) total += r.weight;
    if (r.visibility == Visibility::kFreeSpace && r.value > config_.energy.sigma) violating += r.weight;
  }
  return total > 0 ? violating / total : 1.0;
}

} // namespace kinora::tracking
