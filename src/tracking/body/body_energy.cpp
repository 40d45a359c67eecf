#include "tracking/body/body_energy.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "core/damped_gauss_newton.h"
#include "core/parallel.h"
#include "tracking/body/body_match.h"

namespace kinora::tracking {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kAnyCost = 1e9;

// What moves a point of a part: its bone's twist, then the part's own measures.
constexpr int kLocal = 6 + kPartMeasures;
struct PartEquations {
  Eigen::Matrix<double, kLocal, kLocal> hessian = Eigen::Matrix<double, kLocal, kLocal>::Zero();
  Eigen::Matrix<double, kLocal, 1> gradient = Eigen::Matrix<double, kLocal, 1>::Zero();
};
struct Accumulator {
  std::array<PartEquations, kBodyParts> parts;
  double energy = 0;
};

// A residual whose value grows by direction · movement of the part's point at `position` in the camera.
struct PartResidual {
  std::size_t part;
  double value;
  Vec position, direction;
  std::optional<PartPoint> point; ///< none: the origin of the bone, which the part's own measures leave alone
  double weight;
};

void add(const BodyInCamera& body, const PartResidual& r, Accumulator& sum) {
  Eigen::Matrix<double, kLocal, 1> row;
  row.head<3>() = r.direction;
  row.segment<3>(3) = r.position.cross(r.direction);
  if (r.point) {
    const Vec in_bone = body.bone(r.part).linear().transpose() * r.direction;
    row.tail<kPartMeasures>() = measure_derivative(body.body().parts[r.part], *r.point, in_bone);
  } else {
    row.tail<kPartMeasures>().setZero();
  }
  PartEquations& part = sum.parts[r.part];
  part.hessian.noalias() += (r.weight * row) * row.transpose();
  part.gradient += r.weight * r.value * row;
}

// `found`: the part that the point lies on, or −1.
void add_point(const BodyInCamera& body, const MeasuredPoint& point, int found, const BodyEnergyConfig& config,
               Accumulator& sum) {
  if (found < 0) {
    sum.energy += point.weight * robust_cost(config).cost(kAnyCost);
    return;
  }
  const auto part = static_cast<std::size_t>(found);
  const ClosestSurface surface = closest_surface(body.body().parts[part], body.to_bone(part) * point.position);
  const double squared = surface.distance * surface.distance;
  sum.energy += point.weight * robust_cost(config).cost(squared);
  const double weight = point.weight * robust_cost(config).weight(squared) / (config.sigma * config.sigma);
  const Vec position = body.bone(part) * position_of(body.body().parts[part], surface.point);
  add(body, {part, -surface.distance, position, body.bone(part).linear() * surface.normal, surface.point, weight}, sum);
}

void add_sample(const BodyInCamera& body, const BodySample& sample, const LayerView& view,
                const BodyEnergyConfig& config, Accumulator& sum) {
  const SampleResidual r = sample_residual(body, sample, view, config);
  if (r.visibility != Visibility::kFreeSpace) return;
  const double squared = r.value * r.value;
  sum.energy += r.weight * robust_cost(config).cost(squared);
  const double weight = r.weight * robust_cost(config).weight(squared) / (config.sigma * config.sigma);
  const Vec position = body.bone(sample.part) * position_of(body.body().parts[sample.part], sample.point);
  add(body, {sample.part, r.value, position, r.direction, sample.point, weight}, sum);
}

void add_arm_penalties(const BodyInCamera& body, Accumulator& sum) {
  const std::vector<ArmPenalty> reluctances = arm_penalties(body);
  sum.energy += energy_of(reluctances);
  for (const ArmPenalty& r : reluctances) {
    const Vec position = body.bone(r.part) * position_of(body.body().parts[r.part], r.point);
    add(body, {r.part, r.value, position, r.gradient, r.point, 1}, sum);
  }
}

void add_hand_contact(const BodyInCamera& body, const HandContact& contact, const BodyEnergyConfig& config,
                      Accumulator& sum) {
  sum.energy += contact_energy(contact, body.body(), config);
  const Vec heel = heel_of_hand(body.body(), contact.arm);
  const Vec off = heel - contact.position;
  const double weight =
      config.contact_weight * robust_cost(config).weight(off.squaredNorm()) / (config.sigma * config.sigma);
  for (int axis = 0; axis < 3; ++axis) {
    add(body, {hand_part(contact.arm), off[axis], heel, Vec::Unit(axis), heel_point(), weight}, sum);
  }
}

void add_joint(const BodyInCamera& body, const JointObservation& joint, const DetectedJointsConfig& config,
               Accumulator& sum) {
  sum.energy += energy_of(joint, body.body(), config);
  const Landmark& landmark = landmark_of(joint.joint);
  const Vec position = position_of(landmark, body.body());
  const RayDistance distance(position, joint.ray);
  const double weight = loss_derivative(joint, distance.value.squaredNorm(), config);
  for (std::size_t i = 0; i < 2; ++i) {
    add(body,
        {landmark.part, distance.value[static_cast<Eigen::Index>(i)], position, distance.directions[i], landmark.point,
         weight},
        sum);
  }
}

void merge(const Accumulator& from, Accumulator& to) {
  for (std::size_t i = 0; i < kBodyParts; ++i) {
    to.parts[i].hessian += from.parts[i].hessian;
    to.parts[i].gradient += from.parts[i].gradient;
  }
  to.energy += from.energy;
}

Accumulator add_view(const BodyEvidence& evidence, const BodyInCamera& body, const BodyEnergyConfig& config) {
  constexpr std::size_t kChunk = 512;
  const std::span<const BodySample> samples = body_samples();
  const std::size_t points = evidence.points.size();
  std::vector<Accumulator> sums(chunk_count(points + samples.size(), kChunk));
  parallel_for(points + samples.size(), kChunk, [&](const Chunk& chunk) {
    Accumulator& sum = sums[chunk.index];
    std::array<PartMatch, kChunk> matches;
    const std::size_t end = std::min(chunk.end, points);
    if (chunk.begin < end) {
      match_points(body, std::span(evidence.points).subspan(chunk.begin, end - chunk.begin), config.normal_length,
                   kAnyCost, matches);
    }
    for (std::size_t i = chunk.begin; i < end; ++i) {
      add_point(body, evidence.points[i], matches[i - chunk.begin].part, config, sum);
    }
    for (std::size_t i = std::max(chunk.begin, points); i < chunk.end; ++i) {
      add_sample(body, samples[i - points], *evidence.view, config, sum);
    }
  });
  Accumulator total;
  for (const Accumulator& sum : sums) merge(sum, total);
  add_arm_penalties(body, total);
  for (const JointObservation& joint : evidence.joints) add_joint(body, joint, config.detected, total);
  return total;
}

// The freedoms that move each part, in order.
std::array<std::vector<int>, kBodyParts> find_part_dofs() {
  std::array<std::vector<int>, kBodyParts> dofs;
  for (std::size_t i = 0; i < kBodyParts; ++i) {
    std::array<bool, kDof> moves{};
    std::fill_n(moves.begin(), 6, true);
    for (int j = body_parts()[i].bone; j > 0; j = joints()[static_cast<std::size_t>(j)].parent) {
      const JointInfo& joint = joints()[static_cast<std::size_t>(j)];
      std::fill_n(moves.begin() + 6 + joint.first_angle, joint.angle_count, true);
      moves.at(kPoseDof + joint.length) = true;
    }
    for (const auto measure : measures_of(body_parts()[i])) {
      if (measure) moves.at(kPoseDof + *measure) = true;
    }
    for (int f = 0; f < kDof; ++f) {
      if (moves[static_cast<std::size_t>(f)]) dofs[i].push_back(f);
    }
  }
  return dofs;
}

// From bones and parts to freedoms.
void assemble(const Accumulator& sum, const BodyState& state, const Bones& bones, BodyEquations& equations) {
  static const std::array<std::vector<int>, kBodyParts> dofs = find_part_dofs();
  BoneTwists twists;
  find_bone_twists(state.pose, state.shape, bones, twists);
  for (std::size_t i = 0; i < kBodyParts; ++i) {
    const auto count = static_cast<Eigen::Index>(dofs[i].size());
    Eigen::Matrix<double, kLocal, Eigen::Dynamic, 0, kLocal, kDof> rows(kLocal, count);
    const auto measures = measures_of(body_parts()[i]);
    for (Eigen::Index c = 0; c < count; ++c) {
      const int dof = dofs[i][static_cast<std::size_t>(c)];
      rows.col(c).head<6>() = twists[body_parts()[i].bone].col(dof);
      for (int m = 0; m < kPartMeasures; ++m) {
        const auto measure = measures[static_cast<std::size_t>(m)];
        rows(6 + m, c) = measure && kPoseDof + *measure == dof ? 1.0 : 0.0;
      }
    }
    const Eigen::Matrix<double, kLocal, Eigen::Dynamic, 0, kLocal, kDof> weighted =
        sum.parts[i].hessian.lazyProduct(rows);
    for (Eigen::Index c = 0; c < count; ++c) {
      const int column = dofs[i][static_cast<std::size_t>(c)];
      equations.gradient[column] += rows.col(c).dot(sum.parts[i].gradient);
      for (Eigen::Index r = 0; r <= c; ++r) {
        const int row = dofs[i][static_cast<std::size_t>(r)];
        equations.hessian(row, column) += rows.col(r).dot(weighted.col(c));
      }
    }
  }
  equations.hessian.triangularView<Eigen::StrictlyLower>() = equations.hessian.transpose();
}

} // namespace

BodyEquations evaluate(const BodyEvidence& evidence, const BodyState& state, const BodyPrior& prior,
                       const BodyEnergyConfig& config) {
  BodyEquations equations;
  equations.gradient.setZero();
  equations.hessian.setZero();
  const BodyInCamera body(state);
  Accumulator sum = add_view(evidence, body, config);
  for (const HandContact& contact : prior.hands) add_hand_contact(body, contact, config, sum);
  equations.energy = sum.energy;
  assemble(sum, state, body.body().bones, equations);
  add_prior(state, prior, config.poses, equations);
  return equations;
}

double minimise(const BodyEvidence& evidence, const BodyPrior& prior, const BodyEnergyConfig& config, int iterations,
                bool with_shape, BodyState& state) {
  // Points change their parts and samples their sight, so that a good step may seem to lose a little.
  const int dofs = with_shape ? kDof : kPoseDof;
  MarquardtDamping damping({.min = 1e-4});
  BodyEquations equations = evaluate(evidence, state, prior, config);
  damped_gauss_newton(damping, iterations, [&](double value) -> StepOutcome {
    Eigen::MatrixXd hessian = equations.hessian.topLeftCorner(dofs, dofs);
    hessian.diagonal().array() += value * (hessian.diagonal().array() + 1);
    const Eigen::VectorXd step = hessian.ldlt().solve(-equations.gradient.head(dofs));
    if (!step.allFinite()) return {.is_last = true};
    BodyState next = state;
    next.pose = moved(state.pose, step.head<kPoseDof>());
    if (with_shape) next.shape += step.tail<kMeasures>();
    if (step.cwiseAbs().maxCoeff() < config.small_step) {
      state = next;
      return {.is_taken = true, .is_last = true};
    }
    const BodyEquations tried = evaluate(evidence, next, prior, config);
    if (!(tried.energy < (1 + config.slack) * equations.energy)) return {};
    state = next;
    equations = tried;
    return {.is_taken = true};
  });
  return equations.energy;
}

} // namespace kinora::tracking
