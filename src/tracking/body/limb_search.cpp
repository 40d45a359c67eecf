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

bool is_of(const LimbChain& chain, std::size_t part) {
  return std::find(chain.parts.begin(), chain.parts.end(), part) != chain.parts.end();
}

// A point near the limb, and what it costs without the limb.
struct Candidate {
  MeasuredPoint point;
  double cost;
};

double cut(double cost, const BodyEnergyConfig& config) { return std::min(cost, 4 * config.cutoff * config.cutoff); }

// Points within reach that the rest of the body does not explain well.
std::vector<Candidate> points_for(const LimbChain& chain, const BodyEvidence& evidence, const BodyInCamera& body,
                                  const BodyEnergyConfig& config) {
  const LimbLengths lengths = lengths_of(chain, body.body());
  const double reach = 1.1 * (lengths.upper + lengths.lower + lengths.last);
  const Vec root = body.body().bones[chain.ball].translation();
  std::vector<MeasuredPoint> near;
  for (const MeasuredPoint& point : evidence.points) {
    if ((point.position - root).squaredNorm() <= reach * reach) near.push_back(point);
  }
  std::array<bool, kBodyParts> others;
  for (std::size_t part = 0; part < kBodyParts; ++part) others[part] = !is_of(chain, part);
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
std::vector<Vec> spread_targets(const std::vector<Candidate>& points, const Vec& root, double least_cost) {
  std::vector<Vec> open;
  for (const Candidate& c : points) {
    if (c.cost >= least_cost) open.push_back(c.point.position);
  }
  std::vector<Vec> targets;
  std::vector<double> distance(open.size(), 0);
  for (std::size_t i = 0; i < open.size(); ++i) distance[i] = (open[i] - root).norm();
  while (targets.size() < std::min(kTargets, open.size())) {
    const auto farthest =
        static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    targets.push_back(open[farthest]);
    for (std::size_t i = 0; i < open.size(); ++i) {
      const double d = (open[i] - targets.back()).norm();
      distance[i] = targets.size() == 1 ? d : std::min(distance[i], d);
    }
  }
  return targets;
}

std::vector<Candidate> thinned(const std::vector<Candidate>& points) {
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
  double energy = angle_energy(state.pose.angles, config.poses) + energy_of(find_reluctances(body));
  energy += energy_of(evidence.joints, body.body(), config.detected);
  for (const Candidate& c : points) {
    BodyInCamera::Match match(c.cost);
    for (const std::size_t part : chain.parts) body.match(part, c.point, config.normal_length, match);
    energy += c.point.weight * robust_cost(config).cost(cut(match.squared_distance(), config));
  }
  for (const std::size_t part : chain.parts) {
    for (const BodySample& sample : samples_of(part)) {
      const SampleResidual r = look_at(body, sample, *evidence.view, config);
      if (r.sight == Sight::kFreeSpace) energy += r.weight * robust_cost(config).cost(r.value * r.value);
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
std::vector<Vec> detected_ends(Joint end, const BodyEvidence& evidence, const Vec& root, double reach) {
  std::vector<Vec> places;
  for (const SightedJoint& sighted : evidence.joints) {
    const Landmark& landmark = landmark_of(sighted.joint);
    if (body_parts()[landmark.part].bone != end) continue;
    for (const double depth : {-0.8, -0.4, 0.0, 0.4, 0.8}) {
      const double z = root.z() + depth * reach;
      places.emplace_back(z * sighted.ray.x(), z * sighted.ray.y(), z);
    }
  }
  return places;
}

// Poses of the limb that reach for points that nothing explains, for where it was detected, and all around the ball
// joint.
std::vector<Trial> poses_to_try(Limb limb, const std::vector<Candidate>& points, const BodyEvidence& evidence,
                                const BodyState& state, const BodyEnergyConfig& config) {
  constexpr double kTooFar = 40; // energy of angles that are beyond their limits
  const LimbChain& chain = chain_of(limb);
  const PosedBody body = pose_body(state.pose, state.shape);
  const LimbLengths lengths = lengths_of(chain, body);
  const Vec root = body.bones[chain.ball].translation();
  const double most = angle_energy(state.pose.angles, config.poses) + kTooFar;
  std::vector<Trial> result;
  const auto add = [&](const Vec& target, double beyond, int swivels) {
    for (int i = 0; i < swivels; ++i) {
      Trial trial{0, state};
      const double swivel = 2 * std::numbers::pi * (i + 0.5) / swivels;
      trial.state.pose.angles = reach_for(limb, state.pose.angles, body, target, swivel, beyond);
      if (angle_energy(trial.state.pose.angles, config.poses) < most) result.push_back(trial);
    }
  };
  for (const Vec& target : spread_targets(points, root, config.cutoff * config.cutoff)) {
    add(target, 0, kSwivels);
    add(target, lengths.last, kSwivels);
  }
  for (const Vec& target : detected_ends(chain.end, evidence, root, lengths.upper + lengths.lower)) {
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
  const std::vector<Candidate> judges = thinned(points);
  std::vector<Trial> tried = poses_to_try(limb, points, evidence, state, config);
  parallel_for(tried.size(), 16, [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      tried[i].energy = limb_energy(chain_of(limb), judges, tried[i].state, evidence, config);
    }
  });
  std::stable_sort(tried.begin(), tried.end(), [](const Trial& a, const Trial& b) { return a.energy < b.energy; });
  if (tried.size() > kRefined) tried.resize(kRefined);
  return tried;
}

} // namespace

LimbSight look_at_limb(Limb limb, const BodyEvidence& evidence, const BodyState& state,
                       const BodyEnergyConfig& config) {
  const LimbChain& chain = chain_of(limb);
  const BodyInCamera body(state);
  LimbSight sight;
  for (const std::size_t part : chain.parts) {
    if (body_parts()[part].bone == chain.ball) continue;
    for (const BodySample& sample : samples_of(part)) {
      const SampleResidual r = look_at(body, sample, *evidence.view, config);
      if (r.sight == Sight::kSeen) sight.seen += r.weight;
      if (r.sight == Sight::kHidden) sight.hidden += r.weight;
      if (r.sight == Sight::kFreeSpace && r.value > config.sigma) sight.free_space += r.weight;
    }
  }
  for (const SightedJoint& joint : evidence.joints) {
    const Joint bone = body_parts()[landmark_of(joint.joint).part].bone;
    if (bone != chain.hinge && bone != chain.end) continue;
    const RayDistance distance(place_of(landmark_of(joint.joint), body.body()), joint.ray);
    if (distance.value.norm() > config.detected.cutoff) sight.detected_elsewhere += joint.weight;
  }
  const double least = config.cutoff * config.cutoff;
  for (const Candidate& c : points_for(chain, evidence, body, config)) {
    BodyInCamera::Match match(c.cost);
    for (const std::size_t part : chain.parts) body.match(part, c.point, config.normal_length, match);
    if (match.cost >= least) sight.unexplained += c.point.weight;
  }
  return sight;
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

LimbHealth health_of(const LimbSight& sight) {
  constexpr double kEnough = 0.3; // of the surface that faces the camera
  if (sight.free_space > sight.seen + sight.hidden) return LimbHealth::kLost;
  const bool seen = sight.seen > kEnough * (sight.seen + sight.hidden + sight.free_space);
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
  const std::vector<Candidate> points = points_for(chain, evidence, BodyInCamera(state), config);
  const std::vector<Trial> best = best_trials(limb, points, evidence, state, config);
  const Vec end = place_bones(state.pose, state.shape)[chain.end].translation();
  double least = evaluate(evidence, state, free, config).energy - margin;
  bool changed = false;
  for (const Trial& trial : best) {
    BodyState refined = trial.state;
    double energy = minimise(evidence, free, config, kRefinements, false, refined);
    energy += jump_cost * (place_bones(refined.pose, refined.shape)[chain.end].translation() - end).norm();
    if (!(energy < least)) continue;
    least = energy;
    state = refined;
    changed = true;
  }
  return changed;
}

} // namespace kinora::tracking
