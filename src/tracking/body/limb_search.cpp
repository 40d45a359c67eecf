#include "tracking/body/limb_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "tracking/body/body_match.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr std::size_t kTargets = 8;     // among unexplained points
constexpr std::size_t kMaxPoints = 160; // that candidates are judged by
constexpr int kSwivels = 6;
constexpr std::size_t kRefined = 2; // candidates
constexpr int kRefinements = 4;     // steps of each

bool belongs_to(const LimbChain& chain, std::size_t part) {
  return std::find(chain.parts.begin(), chain.parts.end(), part) != chain.parts.end();
}

// A point near the limb, and what it costs without the limb.
struct Candidate {
  MeasuredPoint point;
  double cost;
};

double truncated_cost(double cost, const BodyEnergyConfig& config) {
  return std::min(cost, 4 * config.cutoff * config.cutoff);
}

// Points within reach that the rest of the body does not explain well.
std::vector<Candidate> unexplained_points(const LimbChain& chain, const BodyEvidence& evidence,
                                          const BodyInCamera& body, const BodyEnergyConfig& config) {
  const LimbLengths lengths = lengths_of(chain, body.body());
  const double reach = 1.1 * (lengths.upper + lengths.lower + lengths.last);
  const Vec root = body.body().bones[chain.ball].translation();
  std::vector<MeasuredPoint> near;
  for (const MeasuredPoint& point : evidence.points) {
    if ((point.position - root).squaredNorm() <= reach * reach) near.push_back(point);
  }
  std::array<bool, kBodyParts> others;
  for (std::size_t part = 0; part < kBodyParts; ++part) others[part] = !belongs_to(chain, part);
  std::vector<PartMatch> matches(near.size());
  match_points(body, near, config.normal_length, 4 * config.cutoff * config.cutoff, others, matches);
  std::vector<Candidate> result;
  for (std::size_t i = 0; i < near.size(); ++i) {
    const auto cost = static_cast<double>(matches[i].cost);
    if (cost > config.sigma * config.sigma) result.push_back({near[i], cost});
  }
  return result;
}

// Each the farthest from those before; the first the farthest from `root`.
std::vector<Vec> farthest_point_targets(const std::vector<Candidate>& points, const Vec& root, double min_cost) {
  std::vector<Vec> candidates;
  for (const Candidate& c : points) {
    if (c.cost >= min_cost) candidates.push_back(c.point.position);
  }
  std::vector<Vec> targets;
  std::vector<double> distance(candidates.size(), 0);
  for (std::size_t i = 0; i < candidates.size(); ++i) distance[i] = (candidates[i] - root).norm();
  while (targets.size() < std::min(kTargets, candidates.size())) {
    const auto farthest =
        static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    targets.push_back(candidates[farthest]);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const double d = (candidates[i] - targets.back()).norm();
      distance[i] = targets.size() == 1 ? d : std::min(distance[i], d);
    }
  }
  return targets;
}

std::vector<Candidate> downsampled(const std::vector<Candidate>& points) {
  if (points.size() <= kMaxPoints) return points;
  std::vector<Candidate> result;
  const double step = static_cast<double>(points.size()) / kMaxPoints;
  for (std::size_t i = 0; i < kMaxPoints; ++i) {
    Candidate c = points[static_cast<std::size_t>(static_cast<double>(i) * step)];
    c.point.weight *= step;
    result.push_back(c);
  }
  return result;
}

// Energy as far as the limb has a say in it.
double limb_energy(const LimbChain& chain, const std::vector<Candidate>& points, const BodyState& state,
                   const BodyEvidence& evidence, const BodyEnergyConfig& config) {
  const BodyInCamera body(state);
  double energy = angle_energy(state.pose.angles, config.poses) + energy_of(arm_penalties(body));
  energy += energy_of(evidence.joints, body.body(), config.detected);
  for (const Candidate& c : points) {
    BodyInCamera::Match match(c.cost);
    for (const std::size_t part : chain.parts) body.match(part, c.point, config.normal_length, match);
    energy += c.point.weight * robust_cost(config).cost(truncated_cost(match.squared_distance(), config));
  }
  for (const std::size_t part : chain.parts) {
    for (const BodySample& sample : samples_of(part)) {
      const SampleResidual r = sample_residual(body, sample, *evidence.view, config);
      if (r.visibility == Visibility::kFreeSpace) energy += r.weight * robust_cost(config).cost(r.value * r.value);
    }
  }
  return energy;
}

// Directions to look for the limb in where no point calls: sides, corners and edges of a cube.
std::vector<Vec> directions() {
  std::vector<Vec> result;
  for (const double x : {-1, 0, 1}) {
    for (const double y : {-1, 0, 1}) {
      for (const double z : {-1, 0, 1}) {
        if (x != 0 || y != 0 || z != 0) result.push_back(Vec(x, y, z).normalized());
      }
    }
  }
  return result;
}

struct Trial {
  double energy;
  BodyState state;
};

// On the ray of the limb's end joint, where a detector has found it, as far away as the limb reaches.
std::vector<Vec> detected_end_positions(Joint end, const BodyEvidence& evidence, const Vec& root, double reach) {
  std::vector<Vec> positions;
  for (const JointObservation& observed : evidence.joints) {
    const Landmark& landmark = landmark_of(observed.joint);
    if (body_parts()[landmark.part].bone != end) continue;
    for (const double depth : {-0.8, -0.4, 0.0, 0.4, 0.8}) {
      const double z = root.z() + depth * reach;
      positions.emplace_back(z * observed.ray.x(), z * observed.ray.y(), z);
    }
  }
  return positions;
}

// Poses of the limb that reach for points that nothing explains, for where it was detected, and all around the ball
// joint.
std::vector<Trial> candidate_poses(Limb limb, const std::vector<Candidate>& points, const BodyEvidence& evidence,
                                   const BodyState& state, const BodyEnergyConfig& config) {
  constexpr double kTooFar = 40; // energy of angles that are beyond their limits
  const LimbChain& chain = chain_of(limb);
  const PosedBody body = pose_body(state.pose, state.shape);
  const LimbLengths lengths = lengths_of(chain, body);
  const Vec root = body.bones[chain.ball].translation();
  const double max_energy = angle_energy(state.pose.angles, config.poses) + kTooFar;
  std::vector<Trial> result;
  const auto add = [&](const Vec& target, double beyond, int swivels) {
    for (int i = 0; i < swivels; ++i) {
      Trial trial{0, state};
      const double swivel = 2 * std::numbers::pi * (i + 0.5) / swivels;
      trial.state.pose.angles = inverse_kinematics(limb, state.pose.angles, body, target, swivel, beyond);
      if (angle_energy(trial.state.pose.angles, config.poses) < max_energy) result.push_back(trial);
    }
  };
  for (const Vec& target : farthest_point_targets(points, root, config.cutoff * config.cutoff)) {
    add(target, 0, kSwivels);
    add(target, lengths.last, kSwivels);
  }
  for (const Vec& target : detected_end_positions(chain.end, evidence, root, lengths.upper + lengths.lower)) {
    add(target, 0, kSwivels);
  }
  for (const double reach : {0.5, 0.8}) {
    for (const Vec& direction : directions()) {
      add(root + reach * (lengths.upper + lengths.lower) * direction, 0, kSwivels / 2);
    }
  }
  return result;
}

// The best few, with their energies.
std::vector<Trial> best_trials(Limb limb, const std::vector<Candidate>& points, const BodyEvidence& evidence,
                               const BodyState& state, const BodyEnergyConfig& config) {
  const std::vector<Candidate> scoring_points = downsampled(points);
  std::vector<Trial> tried = candidate_poses(limb, points, evidence, state, config);
  parallel_for(tried.size(), 16, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      tried[i].energy = limb_energy(chain_of(limb), scoring_points, tried[i].state, evidence, config);
    }
  });
  std::stable_sort(tried.begin(), tried.end(), [](const Trial& a, const Trial& b) { return a.energy < b.energy; });
  if (tried.size() > kRefined) tried.resize(kRefined);
  return tried;
}

} // namespace

LimbVisibility observe_limb(Limb limb, const BodyEvidence& evidence, const BodyState& state,
                            const BodyEnergyConfig& config) {
  const LimbChain& chain = chain_of(limb);
  const BodyInCamera body(state);
  LimbVisibility visibility;
  for (const std::size_t part : chain.parts) {
    if (body_parts()[part].bone == chain.ball) continue;
    for (const BodySample& sample : samples_of(part)) {
      const SampleResidual r = sample_residual(body, sample, *evidence.view, config);
      if (r.visibility == Visibility::kSeen) visibility.seen += r.weight;
      if (r.visibility == Visibility::kHidden) visibility.hidden += r.weight;
      if (r.visibility == Visibility::kFreeSpace && r.value > config.sigma) visibility.free_space += r.weight;
    }
  }
  for (const JointObservation& joint : evidence.joints) {
    const Joint bone = body_parts()[landmark_of(joint.joint).part].bone;
    if (bone != chain.hinge && bone != chain.end) continue;
    const RayDistance distance(position_of(landmark_of(joint.joint), body.body()), joint.ray);
    if (distance.value.norm() > config.detected.cutoff) visibility.detected_elsewhere += joint.weight;
  }
  const double least = config.cutoff * config.cutoff;
  for (const Candidate& c : unexplained_points(chain, evidence, body, config)) {
    BodyInCamera::Match match(c.cost);
    for (const std::size_t part : chain.parts) body.match(part, c.point, config.normal_length, match);
    if (match.cost >= least) visibility.unexplained += c.point.weight;
  }
  return visibility;
}

std::string_view name_of(LimbHealth health) {
  switch (health) {
  case LimbHealth::kSeen:
    return "seen";
  case LimbHealth::kHidden:
    return "hidden";
  case LimbHealth::kLost:
    break;
  }
  return "lost";
}

LimbHealth health_of(const LimbVisibility& visibility) {
  constexpr double kEnough = 0.3; // of the surface that faces the camera
  if (visibility.free_space > visibility.seen + visibility.hidden) return LimbHealth::kLost;
  const bool seen = visibility.seen > kEnough * (visibility.seen + visibility.hidden + visibility.free_space);
  return seen ? LimbHealth::kSeen : LimbHealth::kHidden;
}

bool search_limb(Limb limb, const BodyEvidence& evidence, const BodyPrior& prior, const BodyEnergyConfig& config,
                 double margin, double jump_cost, BodyState& state) {
  const LimbChain& chain = chain_of(limb);
  BodyPrior free = prior;
  for (const Joint joint : {chain.ball, chain.hinge, chain.end}) {
    free.pose_precision.segment(6 + joints()[joint].first_angle, joints()[joint].angle_count).setZero();
  }
  free.hands.clear();
  const std::vector<Candidate> points = unexplained_points(chain, evidence, BodyInCamera(state), config);
  const std::vector<Trial> best = best_trials(limb, points, evidence, state, config);
  const Vec end = forward_kinematics(state.pose, state.shape)[chain.end].translation();
  double least = evaluate(evidence, state, free, config).energy - margin;
  bool changed = false;
  for (const Trial& trial : best) {
    BodyState refined = trial.state;
    double energy = minimise(evidence, free, config, kRefinements, false, refined);
    energy += jump_cost * (forward_kinematics(refined.pose, refined.shape)[chain.end].translation() - end).norm();
    if (!(energy < least)) continue;
    least = energy;
    state = refined;
    changed = true;
  }
  return changed;
}

} // namespace kinora::tracking
